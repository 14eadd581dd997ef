"""Whatever cannot be served is told in one message, with exit code 2, before anything is written."""

from __future__ import annotations

import socket

import pytest
from typer.testing import CliRunner

from host.cli.main import app

MISTAKES = (
    (["--uart", "host"], "tells no UART or no place; for example --uart host=tcp://127.0.0.1:5760"),
    (["--uart", "hots=pty"], "has no UART 'hots'; did you mean 'host'?"),
    (["--uart", "host=pty", "--uart", "host=pty"], "'host' is served already"),
    (["--uart", "host=udp://127.0.0.1:1"], "is no place; there are pty, pty:./host, tcp://"),
    (["--uart", "host=pty:"], "is no place"),
    (["--uart", "host=tcp://127.0.0.1"], "is no HOST:PORT with a port in 0 … 65535"),
    (["--uart", "host=tcp://127.0.0.1:70000"], "is no HOST:PORT"),
    (["--uart", "host=tcp://0.0.0.0:5760"], "could be reached from other machines"),
    (["--uart", "host=rfc2217://:4000"], "is no HOST:PORT"),
    (["--control", "0.0.0.0:5761"], "use 127.0.0.1:5761, or say --allow-remote"),
    (["--control", "example.org:5761"], "could be reached from other machines"),
    (["--control", "5761"], "--control: '5761' is no HOST:PORT"),
    (["--can", "virtual"], "tells no INTERFACE:CHANNEL; for example --can can1=udp_multicast:"),
    (["--can", "can9=virtual:x"], "has no CAN bus 'can9'; did you mean 'can1'?"),
    (["--can", "virtuall:x"], "python-can has no interface 'virtuall'; did you mean 'virtual'?"),
    (["--can", "socketcan:no-such-interface"], "the interface cannot be opened"),
    (["--can", "slcan:/dev/no-such-port"], "the interface cannot be opened"),
    (["--can", "udp_multicast:127.0.0.1"], "the interface cannot be opened"),
    (["--pace", "-1"], "--pace: -1 lies outside"),
    (["--pace", "nan"], "--pace: nan lies outside"),
    (["--pace", "1e9"], "1 is real time, 0 as fast as it goes"),
    (["--duration", "soon"], "--duration soon: is neither a number of seconds"),
    (["--duration", "-3"], "is neither a number of seconds"),
    (["--stall", "0"], "--stall 0: is no positive number"),
    (["--paused"], "--paused: nobody could resume"),
    (["--scenario", "nowhere"], "has no such scenario"),
)


def serve(tmp_path, *options):
    return CliRunner().invoke(
        app, ["serve", "car_mems", "-s", "static", "--out", str(tmp_path / "out"), "-q", *options]
    )


@pytest.mark.parametrize(("options", "told"), MISTAKES, ids=lambda value: " ".join(value)[:30])
def test_one_message_and_exit_code_2(options, told, tmp_path):
    outcome = serve(tmp_path, *options)
    assert outcome.exit_code == 2, outcome.output
    assert told in outcome.output
    assert outcome.output.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_port_in_use(tmp_path):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        for options in (["--uart", f"host=tcp://127.0.0.1:{port}"], ["--control", f"127.0.0.1:{port}"]):
            outcome = serve(tmp_path, *options)
            assert outcome.exit_code == 2
            assert f"cannot listen at 127.0.0.1:{port}: Address already in use" in outcome.output
            assert not (tmp_path / "out").exists()


def test_a_link_that_is_something_else_is_not_touched(tmp_path):
    (tmp_path / "tty").write_text("mine")
    outcome = serve(tmp_path, "--uart", f"gnss=pty:{tmp_path / 'tty'}")
    assert outcome.exit_code == 2
    assert "exists; name a path that does not" in outcome.output
    assert (tmp_path / "tty").read_text() == "mine"
    outcome = serve(tmp_path, "--uart", f"gnss=pty:{tmp_path / 'no' / 'folder'}")
    assert outcome.exit_code == 2
    assert "cannot be made: No such file or directory" in outcome.output
