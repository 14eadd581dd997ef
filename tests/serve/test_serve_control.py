"""The control channel: every command answered, every mistake told with an example."""

from __future__ import annotations

import contextlib
import json
import math
import socket
import time

import pytest
from served_board import Control, ServedHere

from host.serve.commands import EXAMPLES

MISTAKES = (
    (b'{"command": "pausse"}', "did you mean 'pause'?"),
    (b'{"command": 7}', "no command 7"),
    (b'["pause"]', "a command is an object"),
    (b'{"command": "pace", "pace": -1}', "no number in 0"),
    (b'{"command": "pace", "pace": "fast"}', "no number in 0"),
    (b'{"command": "pace", "pace": 1e-9}', "1 is real time"),
    (b'{"command": "pace", "pace": NaN}', "no number in 0"),
    (b'{"command": "pace"}', "the argument 'pace' is missing"),
    (b'{"command": "pause", "for_s": 3}', "no argument 'for_s'; it takes none"),
    (b'{"command": "position", "latitude_deg": 95, "longitude_deg": 0, "height_m": 0}', "latitude_deg = 95"),
    (b'{"command": "inject", "kind": "uart-cut"}', "target"),
    (b'{"command": "inject", "kind": "uart-cutt", "target": "gnss"}', "did you mean 'uart-cut'?"),
    (b'{"command": "inject", "kind": "uart-cut", "target": "gns"}', "did you mean 'gnss'?"),
    (b'{"command": "inject", "kind": "uart-cut", "target": "gnss", "duration_s": 0}', "duration_s"),
    (b'{"command": "inject", "kind": "uart-cut", "target": "gnss", "at_s": 5}', "no argument 'at_s'"),
    (
        b'{"command": "inject", "kind": "gnss-position-jump", "target": "U3"}',
        "must say by how much gnss-position-jump is off",
    ),
    (
        b'{"command":"inject","kind":"uart-bit-errors","target":"gnss","parameters":{"probability":2}}',
        "must lie in 0",
    ),
    (b'{"command": "clear", "name": "nothing"}', "there is no fault 'nothing'; none has been injected"),
    (b'{"command": "status", "id": ' + b"[" * 480 + b"]" * 480 + b"}", "at most 8 levels"),
    (b'{"command": "pace", "pace": ' + b'{"a":' * 480 + b"1" + b"}" * 481, "at most 8 levels"),
    (b'{"command":"inject","kind":"uart-garbage","target":"gnss","parameters":{"length":1e30}}', "length"),
    (
        b'{"command":"inject","kind":"uart-garbage","target":"gnss","parameters":{"length":1%s}}'
        % (b"0" * 18),
        "there may be 1",
    ),
    (
        b'{"command":"inject","kind":"uart-wrong-baud","target":"gnss","parameters":{"baud":1%s}}'
        % (b"0" * 12),
        "must lie in 1",
    ),
    (
        b'{"command":"inject","kind":"gnss-time-jump","target":"U3","parameters":{"offset_s":1e300}}',
        "lies outside -1e+09",
    ),
    (
        b'{"command":"inject","kind":"gnss-position-jump","target":"U3","parameters":{"down_m":-1e300}}',
        "lies outside -1e+09",
    ),
    (b"{]", "no JSON"),
)


def test_every_mistake_is_told_with_an_example_and_changes_nothing():
    with ServedHere(None, duration_s=1e6) as board:
        before = board.control.ask("status")
        for line, told in MISTAKES:
            reply = board.control.say(line)
            assert not reply["ok"]
            assert told in reply["error"]
            assert reply["example"]["command"] in EXAMPLES
        assert board.control.ask("status") == before
        assert board.control.ask("stop", id="last") == {
            "ok": True,
            "command": "stop",
            "time_s": 0.0,
            "id": "last",
        }
        board.ended()


def test_every_example_is_understood():
    with ServedHere(None, duration_s=1e6) as board:
        for name, arguments in EXAMPLES.items():
            reply = board.control.ask(name, **arguments)
            if name in ("press", "screen"):  # tests/serve/test_serve_panel.py asks a board that has them
                assert reply["error"].startswith("board car_mems has no ")
                continue
            assert reply["ok"], reply
            assert reply["command"] == name
        board.ended()


def test_a_connection_that_does_not_speak_json_is_ended():
    with ServedHere(None, duration_s=1e6) as board:
        web = Control(board.places["control"])
        reply = web.say(b'POST / HTTP/1.1\r\nHost: x\r\n\r\n{"command": "stop"}')
        assert "the connection ends" in reply["error"]
        assert web.connection.recv(100) == b""
        endless = Control(board.places["control"])
        endless.connection.sendall(b"{" + b" " * 70_000)
        assert "one line of at most" in json.loads(endless.connection.recv(1000))["error"]
        assert board.control.ask("status")["time_s"] == 0.0
        board.control.ask("stop")
        board.ended()


def test_a_last_line_that_nothing_ends_is_answered():
    """`printf '{…}' | nc -N HOST PORT`: no line feed, and the end of what the client says."""
    with ServedHere(None, duration_s=1e6) as board:
        caller = Control(board.places["control"]).connection
        caller.sendall(b'{"command": "status", "id": 1}\n{"command": "pace", "pace": 2.0, "id": 2}')
        caller.shutdown(socket.SHUT_WR)
        lines = caller.makefile("rb").read().splitlines()
        assert [json.loads(line)["id"] for line in lines] == [1, 2]
        silent = Control(board.places["control"]).connection
        silent.shutdown(socket.SHUT_WR)
        assert silent.recv(10) == b""
        broken = Control(board.places["control"]).connection
        broken.sendall(b'{"command": "sto')
        broken.shutdown(socket.SHUT_WR)
        assert "no JSON" in json.loads(broken.makefile("rb").read())["error"]
        assert board.control.ask("status")["pace"] == 2.0
        board.control.ask("stop")
        board.ended()


def test_commands_of_clients_that_do_not_wait_for_an_answer_are_done():
    with ServedHere(None, duration_s=1e6) as board:
        for k in range(40):
            with Control(board.places["control"]).connection as caller:
                caller.sendall(b'{"command": "pace", "pace": %d.0}\n' % (k + 1))
            while board.control.ask("status")["pace"] != k + 1.0:
                time.sleep(0.001)
        board.control.ask("stop")
        board.ended()


def test_commands_without_end_leave_the_run_its_time():
    """Ten clients ask for figures as fast as they can and never read; one more is still answered."""
    with ServedHere(None, duration_s=1e6, pace=1.0) as board:
        board.control.ask("resume")
        board.control.until(1.0)
        rude = [Control(board.places["control"]).connection for _ in range(10)]
        for connection in rude:
            connection.settimeout(0.01)
        end = time.monotonic() + 4.0
        before_s = board.control.ask("status")["running_s"]
        answers = 0
        while time.monotonic() < end:
            for connection in rude:
                with contextlib.suppress(OSError):
                    connection.sendall(b'{"command": "metrics"}\n' * 100)
            answers += board.control.ask("status")["ok"]
        after = board.control.ask("status")
        for connection in rude:
            connection.close()
        late = [
            Control(board.places["control"]) for _ in range(5)
        ]  # what the rude ones left does not hold them up
        assert all(control.ask("status")["ok"] for control in late)
        board.control.ask("stop")
        board.ended()
    assert answers > 5
    assert after["running_s"] - before_s >= 4.0
    assert after["slips"] == 0


def test_a_vehicle_that_stands_is_put_elsewhere_and_the_receiver_goes_there(tmp_path):
    with ServedHere(tmp_path / "out", duration_s=90.0) as board:
        board.control.ask("position", latitude_deg=48.1, longitude_deg=11.6, height_m=500.0)
        board.control.ask("resume")
        result = board.ended()
    assert result["gnss"]["position_horizontal_rms_m"] < 5.0  # against the truth, which is there too
    last = (tmp_path / "out" / "solution.csv").read_text().splitlines()[-1].split(",")
    assert [float(x) for x in last[1:3]] == pytest.approx([48.1, 11.6], abs=1e-4)


def test_a_vehicle_that_moves_cannot_be_put_elsewhere():
    with ServedHere(None, duration_s=100.0, scenario="town-open") as board:
        reply = board.control.ask("position", **EXAMPLES["position"])
        assert "its vehicle moves; only one that stands" in reply["error"]
        board.control.ask("stop")
        board.ended()


def test_metrics_can_be_read_while_it_runs_and_become_those_of_the_result():
    with ServedHere(None, duration_s=150.0, pace=0.0) as board:
        board.control.ask("resume")
        meanwhile = board.control.ask("metrics")
        result = board.ended()
    assert meanwhile["ok"]
    assert set(meanwhile["metrics"]) == set(result["metrics"])
    assert math.isfinite(result["metrics"]["position_horizontal_rms_m"])


def test_a_fault_fires_counts_and_is_cleared():
    with ServedHere(None, duration_s=30.0, pace=0.0) as board:
        first = board.control.ask("inject", kind="uart-cut", target="gnss")
        assert first["name"] == "uart-cut gnss"
        second = board.control.ask("inject", kind="uart-cut", target="gnss", duration_s=1.0)
        assert second["name"] == "uart-cut gnss 2"
        again = board.control.ask("inject", kind="uart-cut", target="gnss", name="uart-cut gnss")
        assert "give it another name" in again["error"]
        assert board.control.ask("clear", name="uart-cut gnss")["fired"] == 0
        board.control.ask("inject", kind="nav-nan", target="mcu")
        assert "over by itself" in board.control.ask("clear", name="nav-nan mcu")["error"]
        board.control.ask("resume")
        fired = {fault["name"]: fault["fired"] for fault in board.ended()["faults"]}
    assert fired["uart-cut gnss"] == 0
    assert fired["uart-cut gnss 2"] > 0
    assert fired["nav-nan mcu"] == 1


@pytest.mark.parametrize("name", ["spi-missing", "chip-off", "uart-cut", "can-disturbance", "log-removed"])
def test_a_cleared_fault_strikes_no_more(name):
    targets = {"spi-missing": "imu", "chip-off": "U2", "can-disturbance": "can1", "log-removed": "sdcard"}
    with ServedHere(None, duration_s=12.0, pace=40.0) as board:
        board.control.ask("resume")
        board.control.until(4.0)
        placed = board.control.ask("inject", kind=name, target=targets.get(name, "gnss"))
        board.control.until(7.0)
        fired = board.control.ask("clear", name=placed["name"])["fired"]
        result = board.ended()
    assert fired > 0
    assert [fault["fired"] for fault in result["faults"]] == [fired]
