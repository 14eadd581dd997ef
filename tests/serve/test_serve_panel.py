"""Keys and display of a served board: an operator far away, and a replay that needs none."""

from __future__ import annotations

from served_board import ServedHere

from host.capture.reader import CaptureReader, Decoded
from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict

SETTINGS = ("panel.mode=settings", "expect={}", 'segment=[{kind="rest",duration_s=60.0}]')


def test_keys_are_pressed_the_display_is_read_and_a_replay_does_the_same(tmp_path):
    with ServedHere(tmp_path / "out", duration_s=60.0, board="gfsins", changes=SETTINGS, pace=20.0) as board:
        board.control.ask("resume")
        board.control.until(3.0)
        first = board.control.ask("screen")
        board.control.ask("pause")
        pressed = board.control.ask("press", key="DOWN")
        assert pressed["ok"], pressed
        assert pressed["held_s"] == 0.15
        again = board.control.ask("press", key="DOWN")
        board.control.ask("resume")
        board.control.until(pressed["time_s"] + 1.0)
        second = board.control.ask("screen")
        board.control.ask("press", key="OK", held_s=0.3)
        board.control.until(second["time_s"] + 2.0)
        third = board.control.ask("screen")
        wrong = [
            board.control.ask("press", key="ENTER"),
            board.control.ask("press", key=5),
            board.control.ask("press"),
            board.control.ask("press", key="OK", held_s=0),
            board.control.ask("press", key="OK", held_s=1e9),
            board.control.ask("screen", line=1),
        ]
        board.control.ask("stop")
        board.ended()
    assert first["lines"][0].startswith("SETTINGS")
    assert first["lines"][1] == second["lines"][1] == "Status"
    assert first["rows"] != second["rows"]
    assert third["lines"][0].startswith("Scale, offset")
    assert again["error"].startswith("press: DOWN is held until")
    assert {len(row) for row in third["rows"]} == {128}
    assert len(third["rows"]) == 64
    told = [reply["error"] for reply in wrong]
    assert "there is no key 'ENTER'" in told[0]
    assert told[1] == 'press: key = 5 is no text; for example "OK"'
    assert told[2] == "press: the argument 'key' is missing"
    assert "held_s = 0 is no number in 0.001 … 3600" in told[3]
    assert "held_s = 1000000000.0" in told[4]
    assert "there is no argument 'line'" in told[5]
    capture = tmp_path / "out" / "run.mcap"
    control = [
        r.value["command"] for r in CaptureReader(capture) if isinstance(r, Decoded) and r.topic == "/control"
    ]
    assert control.count("press") == 2
    replayed = replay_strict(ReplayRequest(capture))
    assert replayed.ok, replayed.difference


def test_a_board_without_a_panel_says_so():
    with ServedHere(None, duration_s=1e6) as board:
        assert board.control.ask("screen")["error"] == "board car_mems has no display"
        assert board.control.ask("press", key="OK")["error"] == "board car_mems has no keys"
        board.control.ask("stop")
        board.ended()
