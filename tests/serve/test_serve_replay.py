"""What was done to a served board from outside is in its capture: a strict replay comes to the same state."""

from __future__ import annotations

import os
import random
import signal
import time

import can
import pytest
from served_board import Served, ServedHere
from typer.testing import CliRunner

from host.capture.overview import look_over
from host.capture.reader import CaptureReader, Decoded
from host.cli.main import app
from host.recovery.whole_reader import WholeReader
from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict

FAULTS = (
    {"kind": "uart-cut", "target": "gnss", "duration_s": 2.0},
    {"kind": "can-disturbance", "target": "can1", "duration_s": 0.5},
    {"kind": "spi-bit-errors", "target": "imu", "parameters": {"probability": 0.01}, "duration_s": 1.0},
    {"kind": "gnss-position-jump", "target": "U3", "duration_s": 3.0, "parameters": {"north_m": 50.0}},
    {"kind": "log-removed", "target": "sdcard"},
    {"kind": "chip-off", "target": "U2"},
    {"kind": "nav-nan", "target": "mcu"},
    {"kind": "can-disturbance", "target": "can1", "name": "bus torn"},
    {"kind": "cpu-reset", "target": "mcu"},
)


def commands_of(path) -> list[dict]:
    return [r.value for r in CaptureReader(path) if isinstance(r, Decoded) and r.topic == "/control"]


def test_everything_that_was_done_replays_to_the_same_state(tmp_path):
    noise = random.Random(7)
    channel = f"serve-{os.getpid()}"
    lines = ("host=tcp://127.0.0.1:0", "gnss=tcp://127.0.0.1:0")
    with (
        ServedHere(
            tmp_path / "out", *lines, duration_s=60.0, pace=30.0, cans=(f"virtual:{channel}",)
        ) as board,
        can.Bus(interface="virtual", channel=channel) as bus,
    ):
        clients = [board.connect(name) for name in ("host", "gnss")]
        board.control.ask("resume")
        for number, fault in enumerate(FAULTS):
            board.control.until(5.0 + 5.0 * number)
            assert board.control.ask("inject", **fault)["ok"]
            for client in clients:
                client.sendall(noise.randbytes(300))
                client.recv(1 << 20)
            for identifier in (1, 0x7FF, 0x1234567):
                bus.send(
                    can.Message(
                        arbitration_id=identifier,
                        data=noise.randbytes(noise.randrange(9)),
                        is_extended_id=identifier > 0x7FF,
                    )
                )
        board.control.until(51.0)
        for name in ("bus torn", "chip-off U2", "log-removed sdcard"):
            assert board.control.ask("clear", name=name)["ok"]
        position = {"latitude_deg": 48.1, "longitude_deg": 11.6, "height_m": 500.0}
        assert board.control.ask("position", **position)["ok"]
        result = board.ended()
    assert [fault for fault in result["serve"]["faults"] if not fault["fired"]] == []
    assert result["serve"]["can"][0]["frames_written"] == 3 * len(FAULTS)
    replayed = replay_strict(ReplayRequest(tmp_path / "out" / "run.mcap"))
    assert replayed.difference is None
    assert replayed.state_hash == result["state_hash"]
    commands = commands_of(tmp_path / "out" / "run.mcap")
    asked = [one["command"] for one in commands if one["command"] not in ("can-frames", "status")]
    assert asked == ["serve-can", "resume", *["inject"] * len(FAULTS), *["clear"] * 3, "position"]
    times = [one["time_ns"] for one in commands]
    assert times == sorted(times)


def test_without_the_commands_the_replay_would_differ(tmp_path, monkeypatch):
    with ServedHere(tmp_path / "out", duration_s=6.0, pace=0.0) as board:
        board.control.ask("inject", kind="can-disturbance", target="can1", duration_s=1.0)
        board.control.ask("resume")
        board.ended()
    monkeypatch.setattr("host.replay.control_tape.ControlTape.load", lambda _tape, _messages: None)
    assert not replay_strict(ReplayRequest(tmp_path / "out" / "run.mcap")).ok


def test_the_pace_and_pauses_change_nothing_of_what_the_board_does(tmp_path):
    hashes = set()
    for number, pace in enumerate((0.0, 37.0)):
        with ServedHere(tmp_path / str(number), duration_s=12.0, pace=pace) as board:
            board.control.ask("resume")
            if pace:
                board.control.until(3.0)
                assert board.control.ask("pause")["ok"]
                stands_at = board.control.ask("status")["time_s"]
                time.sleep(0.1)
                assert board.control.ask("status")["time_s"] == stands_at < 12.0
                assert board.control.ask("pace", pace=80.0)["pace"] == 80.0
                board.control.ask("resume")
            hashes.add(board.ended()["state_hash"])
    assert len(hashes) == 1


@pytest.mark.parametrize(
    "moment_s", [2.3, *(pytest.param(one, marks=pytest.mark.soak) for one in (0.95, 5.9, 11.2, 17.7, 26.4))]
)
def test_after_kill_minus_nine_the_capture_is_there_and_replays(moment_s, tmp_path):
    options = ("--uart", "host=tcp://127.0.0.1:0", "--pace", "4")
    with Served(tmp_path / "out", *options, paused=False) as board:
        board.connect("host").sendall(b"hello")
        board.control.ask("inject", kind="can-disturbance", target="can1", duration_s=0.3)
        board.control.until(moment_s)
        board.process.send_signal(signal.SIGKILL)
        board.process.wait()
    capture = tmp_path / "out" / "run.mcap.part"
    replayed = replay_strict(ReplayRequest(capture))
    assert replayed.difference is None
    assert not replayed.capture_complete
    assert moment_s - replayed.duration_s < 1.0
    assert look_over(WholeReader(capture)).recorded_s == replayed.duration_s
    assert commands_of(capture)[0]["command"] == "inject"
    solutions = [r.time_ns for r in WholeReader(capture) if getattr(r, "topic", "") == "/solution"]
    assert replayed.duration_s - solutions[-1] / 1e9 < 0.5


def test_a_capture_with_commands_goes_through_the_tools(tmp_path):
    with ServedHere(tmp_path / "out", duration_s=6.0) as board:
        board.control.ask("inject", kind="can-disturbance", target="can1", duration_s=1.0)
        board.control.ask("pace", pace=0.0)
        board.control.ask("resume")
        board.ended()
    for kind in ("csv", "parquet"):
        outcome = CliRunner().invoke(
            app, ["capture", "export", str(tmp_path / "out"), "-f", kind, "-o", str(tmp_path / kind)]
        )
        assert outcome.exit_code == 0, outcome.output
    rows = (tmp_path / "csv" / "control.csv").read_text().splitlines()
    assert rows[0] == "t_s,command,arguments"
    assert [row.split(",")[1] for row in rows[1:]] == ["inject", "pace", "resume"]
    part = tmp_path / "part.mcap"
    CliRunner().invoke(
        app, ["capture", "cut", str(tmp_path / "out"), "--from", "0", "--to", "3", "-o", str(part)]
    )
    replayed = replay_strict(ReplayRequest(part))
    assert replayed.difference is None
    assert replayed.duration_s == pytest.approx(3.0)
