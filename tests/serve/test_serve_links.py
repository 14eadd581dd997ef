"""Serial links with real clients in processes of their own: nothing is lost, nothing comes twice."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from served_board import Served, ServedHere, heard_by, serial_client

READER = Path(__file__).with_name("link_reader.py")
MON_VER_POLL = "b5620a0400000e34"
MON_VER_ANSWER = "b5620a04"
ANYWHERE = {"pty": "pty", "tcp": "tcp://127.0.0.1:0", "rfc2217": "rfc2217://127.0.0.1:0"}


def line(result: dict, name: str) -> dict:
    return next(one for one in result["serve"]["uarts"] if one["name"] == name)


def url_of(place: str) -> str:
    return place.replace("tcp://", "socket://")


@pytest.mark.parametrize("kind", ANYWHERE)
def test_a_pyserial_client_gets_every_byte_at_full_speed(kind):
    with ServedHere(None, f"host={ANYWHERE[kind]}", duration_s=15.0) as board:
        client = serial_client(url_of(board.places["host"]), "--quiet-s", "1")
        time.sleep(0.1)  # a pseudo-terminal is looked at fifty times a second
        board.control.ask("resume")
        heard = heard_by(client)
        sent = line(board.ended(), "host")
    assert sent["bytes_sent"] > 20_000
    assert (heard["bytes"], heard["sha256"]) == (sent["bytes_sent"], sent["sha256_sent"])
    assert (sent["lost"], sent["cut_off"], sent["clients"]) == (0, 0, 1)


@pytest.mark.parametrize("kind", ANYWHERE)
def test_a_client_of_the_receivers_line_talks_with_the_receiver(kind):
    with ServedHere(None, f"gnss={ANYWHERE[kind]}", duration_s=60.0, pace=50.0) as board:
        board.control.ask("resume")
        board.control.until(5.0)  # by then the board has configured it
        asking = ("--write", MON_VER_POLL, "--expect", MON_VER_ANSWER, "--quiet-s", "1")
        heard = heard_by(serial_client(url_of(board.places["gnss"]), *asking))
        result = board.ended()
    assert heard["found"]
    assert line(result, "gnss")["bytes_written"] == len(MON_VER_POLL) // 2
    gnss_tx = next(bus for bus in result["buses"] if bus["name"] == "gnss.tx")
    assert gnss_tx["bytes"] == 179  # what the board itself has sent to configure the receiver


def test_what_a_client_writes_to_the_board_is_line_traffic_at_the_lines_rate():
    with ServedHere(None, "host=tcp://127.0.0.1:0", duration_s=20.0) as board:
        with board.connect("host") as client:
            client.sendall(bytes(range(256)) * 400)
            time.sleep(0.2)
            board.control.ask("resume")
            while client.recv(1 << 16):
                pass
        result = board.ended()
    host_rx = next(bus for bus in result["buses"] if bus["name"] == "host.rx")
    assert host_rx["bytes"] == line(result, "host")["bytes_written"] == 102_400
    assert host_rx["load"] == pytest.approx(102_400 * 10 / 230_400 / 20.0, rel=1e-6)


def test_what_hit_and_run_writers_leave_is_bounded(tmp_path):
    """Each writes 30 KB and goes; the run is paused, so that nothing of it reaches the line."""
    with ServedHere(None, "host=tcp://127.0.0.1:0", duration_s=1e6) as board:
        for _ in range(150):
            with contextlib.suppress(OSError), board.connect("host") as writer:
                writer.sendall(bytes(30_000))
        deadline = time.monotonic() + 20.0
        while not any("turned away" in line for line in board.told) and time.monotonic() < deadline:
            time.sleep(0.01)
        (line,) = board.control.ask("status")["uarts"]
        assert 1 << 20 <= line["waiting"] < 2_200_000
        assert any("still wait for the line" in line for line in board.told)
        board.control.ask("pace", pace=0.0)
        board.control.ask("resume")
        board.control.until(board.control.ask("status")["time_s"] + 120.0, limit_s=60.0)
        assert board.control.ask("status")["uarts"][0]["waiting"] == 0
        with board.connect("host") as reader:
            assert reader.recv(1000)
        board.control.ask("stop")
        board.ended()


def test_several_clients_come_and_go_while_the_run_goes_on():
    with ServedHere(None, "host=tcp://127.0.0.1:0", duration_s=1e6, pace=10.0) as board:
        board.control.ask("resume")
        for k in range(6):
            clients = [board.connect("host") for _ in range(k + 1)]
            assert all(client.recv(100) for client in clients)
            for client in clients:
                client.close()
        board.control.until(board.control.ask("status")["time_s"] + 1.0)
        board.control.ask("stop")
        result = board.ended()
    assert line(result, "host")["clients"] == 21
    assert line(result, "host")["clients_now"] == 0


def stalled_client(board: ServedHere) -> socket.socket:
    host, _, port = board.places["host"].removeprefix("tcp://").rpartition(":")
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.connect((host, int(port)))
    return client


def test_a_stalled_client_at_a_pace_loses_one_piece_and_disturbs_nobody():
    with ServedHere(None, "host=tcp://127.0.0.1:0", duration_s=500.0, pace=500.0) as board:
        stalled = stalled_client(board)
        reader = board.connect("host")
        came = bytearray()
        reading = threading.Thread(target=read_all, args=(reader, came))
        reading.start()
        board.control.ask("resume")
        while board.control.ask("status")["uarts"][0]["lost"] < 100_000:
            time.sleep(0.01)
        held = bytearray()
        read_all(stalled, held)
        reading.join()
        sent = line(board.ended(), "host")
    assert hashlib.sha256(came).hexdigest() == sent["sha256_sent"]
    assert sent["lost"] >= 100_000
    assert len(held) == sent["bytes_sent"] - sent["lost"]
    assert came.startswith(held[:200_000])
    assert any("does not keep up" in told for told in board.told)


def read_all(connection: socket.socket, into: bytearray) -> None:
    """Up to the end."""
    with connection:
        while data := connection.recv(1 << 16):
            into += data


def test_without_a_pace_a_client_that_stalls_is_waited_for_and_then_cut_off():
    with ServedHere(None, "host=tcp://127.0.0.1:0", duration_s=200.0, stall_s=1.0) as board:
        _stalled = stalled_client(board)
        time.sleep(0.1)
        board.control.ask("resume")
        time.sleep(0.6)
        assert 0.0 < board.control.ask("status")["time_s"] < 199.0
        result = board.ended()
    assert line(result, "host")["cut_off"] == 1
    assert any("cut off" in told for told in board.told)
    assert result["duration_s"] == 200.0


def test_two_programs_at_one_rfc_2217_port_and_a_rate_that_is_not_the_lines():
    with ServedHere(None, "host=rfc2217://127.0.0.1:0", duration_s=5.0) as board:
        clients = [
            serial_client(board.places["host"], "--quiet-s", "1", "--baud", baud)
            for baud in ("9600", "230400")
        ]
        board.control.ask("resume")
        heard = [heard_by(client) for client in clients]
        sent = line(board.ended(), "host")
    assert {one["sha256"] for one in heard} == {sent["sha256_sent"]}
    notes = [told for told in board.told if "baud" in told]
    assert len(notes) == 1
    assert "asks for 9600 baud; the line runs at 230400" in notes[0]


def test_what_one_client_of_a_terminal_has_not_read_is_not_for_the_next_one(tmp_path):
    with ServedHere(None, f"host=pty:{tmp_path / 'tty'}", duration_s=1e6, pace=50.0) as board:
        board.control.ask("resume")
        with (tmp_path / "tty").open("rb", buffering=0):
            board.control.until(10.0)  # it reads nothing: the terminal is full
        time.sleep(0.3)
        board.control.ask("pause")
        with (tmp_path / "tty").open("rb", buffering=0) as second:
            time.sleep(0.2)
            board.control.ask("pace", pace=1.0)
            board.control.ask("resume")
            fresh = second.read(4096)
        board.control.ask("stop")
        board.ended()
    assert 0 < len(fresh) < 2000
    assert not (tmp_path / "tty").is_symlink()


@pytest.mark.parametrize("written", [b"", b"x" * 3000])
def test_a_terminal_that_is_opened_again_at_once_is_served_again(written, tmp_path):
    """As programs do that look whether a port is there before they use it."""
    places = (f"gnss=pty:{tmp_path / 'tty'}",)
    with ServedHere(None, *places, duration_s=1e6, pace=20.0) as board:
        board.control.ask("resume")
        heard = []
        for _ in range(8):
            terminal = os.open(tmp_path / "tty", os.O_RDWR | os.O_NOCTTY)
            os.write(terminal, written)
            time.sleep(0.05)
            os.close(terminal)
            terminal = os.open(tmp_path / "tty", os.O_RDWR | os.O_NOCTTY)
            heard.append(bool(select.select([terminal], [], [], 5.0)[0]))
            os.close(terminal)
            time.sleep(0.05)
        board.control.ask("stop")
        result = board.ended()
    assert all(heard)
    assert line(result, "gnss")["bytes_written"] == 8 * len(written)


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_with_a_whole_folder(by, tmp_path):
    with Served(tmp_path / "out", "--uart", "gnss=pty", paused=False) as board:
        board.control.until(1.0)
        result = board.end(by)
    assert board.code == 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"run.mcap", "solution.csv", "manifest.json", "result.json", "report.html"} <= names
    assert json.loads((tmp_path / "out" / "manifest.json").read_text())["status"] == "complete"
    assert result["duration_s"] >= 1.0
    assert result["expectations"] == []  # of the whole scenario; none of them could be met yet


def test_while_the_whole_pc_stands_still_nobody_is_cut_off(tmp_path):
    options = ("--uart", "host=tcp://127.0.0.1:0", "--pace", "0", "--duration", "200000", "--stall", "2")
    with Served(tmp_path / "out", *options, "--no-capture") as board:
        reader = subprocess.Popen(
            [sys.executable, str(READER), *board.places["host"].removeprefix("tcp://").rsplit(":", 1)],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert reader.stdout is not None
        assert reader.stdout.readline() == "open\n"
        board.control.ask("resume")
        reader.send_signal(signal.SIGSTOP)
        while not board.control.ask("status")["uarts"][0]["backlog"]:
            time.sleep(0.01)
        board.process.send_signal(signal.SIGSTOP)
        time.sleep(2.5)
        board.process.send_signal(signal.SIGCONT)
        time.sleep(0.2)
        reader.send_signal(signal.SIGCONT)
        board.control.until(board.control.ask("status")["time_s"] + 100.0)
        board.control.ask("stop")
        count, digest, gaps, _frames = reader.communicate()[0].split()
        sent = line(board.ended(), "host")
    assert sent["cut_off"] == 0
    assert (int(count), digest, gaps) == (sent["bytes_sent"], sent["sha256_sent"], "0")
