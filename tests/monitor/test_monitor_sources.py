"""Captures and boards: played at their pace, jumped in, cut off; words that mean nothing."""

import json

import pytest
from monitor_command import last_line, monitor
from spoken_drive import manifest, solution, spoken, write_capture

from firmware.link.frames import STATUS, FrameWriter
from host.capture.writer import CaptureWriter
from host.monitor.capture_source import CaptureSource
from host.monitor.view import MonitorView
from host.record.result import RunRequest
from host.run.runner import run


def test_a_capture_of_a_run_that_was_cut_off(tmp_path):
    part = write_capture(tmp_path / "run.mcap", spoken(20), finished=False)
    assert part.suffix == ".part"
    cut = tmp_path / "cut.mcap.part"
    cut.write_bytes(part.read_bytes()[:-5000])
    whole = last_line(str(part), "--once")
    assert whole["solution"]["t_s"] == 20.0
    assert "not whole" in whole["source"]
    result = monitor(str(cut), "--once", "--json")
    assert result.exit_code == 2  # one block, and that one is cut: nothing is left to show
    assert "nothing to show" in result.stderr


def test_json_lines_come_each_second_of_the_capture(tmp_path):
    path = write_capture(tmp_path / "run.mcap", spoken(8))
    result = monitor(str(path), "--json", "--speed", "0")
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert [round(line["t_s"]) for line in lines] == [1, 2, 3, 4, 5, 6, 7, 8, 8]
    # what was said up to the second, and nothing later
    assert [line["solution"]["t_s"] for line in lines[:4]] == pytest.approx([0.9, 1.9, 2.9, 3.9])


def test_pace_pause_and_jumps(tmp_path, monkeypatch):
    """A clock of our own: at double speed two seconds a second; a jump back begins anew and lands right."""
    clock = [100.0]
    monkeypatch.setattr("host.monitor.pace.time.monotonic", lambda: clock[0])
    source = CaptureSource(write_capture(tmp_path / "run.mcap", spoken(60)), 2.0)
    view = MonitorView("drive")

    def play(seconds: float) -> float:
        for _ in range(round(seconds * 10)):
            clock[0] += 0.1
            source.pump(view, 60.0)
        return source.now_s

    source.pump(view, 60.0)
    begin = source.now_s
    assert play(5.0) == pytest.approx(begin + 10.0, abs=0.01)
    assert view.state.solution.time_us == 9_900_000
    source.press(" ", view)
    assert play(3.0) == pytest.approx(begin + 10.0, abs=0.01)
    source.press(" ", view)
    source.press("right", view)
    source.pump(view, 60.0)
    assert source.now_s == pytest.approx(begin + 20.0, abs=0.01)
    assert play(1.0) == pytest.approx(begin + 22.0, abs=0.2)
    source.press("left", view)
    source.pump(view, 60.0)
    assert source.now_s == pytest.approx(begin + 12.0, abs=0.2)
    assert view.state.solution.time_us == pytest.approx(11.9e6, abs=2e5)
    source.press("-", view)
    assert play(1.0) == pytest.approx(begin + 13.0, abs=0.2)
    assert view.link.garbage_bytes == 0
    source.press("+", view)
    source.press("right", view)
    for _ in range(6):
        source.press("right", view)
        source.pump(view, 60.0)
    assert source.ended
    assert view.state.solution.time_us == 60_000_000


def test_a_board_is_run_and_shown():
    """Loads and activations are those that the run's own report tells, satellites those of its receiver."""
    shown = last_line("car_mems", "--scenario", "static", "--seconds", "30", "--once")
    request = RunRequest(
        board="car_mems",
        scenario="static",
        profile=None,
        seed=1,
        overrides=("profile.task_frames=true", "duration_s=30"),
        data_dir=None,
        out_dir=None,
        capture=False,
    )
    (cpu,) = run(request).cpu
    told = {task.name[:12]: task for task in cpu.tasks}
    seen = {task["name"]: task for task in shown["tasks"]}
    assert set(seen) == set(told)
    for name, task in seen.items():
        # told once a second, the last time up to a second before the end
        assert task["activations"] == pytest.approx(told[name].activations, rel=0.04, abs=12)
        assert task["worst_response_us"] <= told[name].worst_response_us
        assert task["busy_us"] / 29.5e6 == pytest.approx(told[name].load, rel=0.05, abs=1e-5)
        assert task["deadlines_missed"] == told[name].deadline_misses
    assert seen["navigation"]["load"] == pytest.approx(told["navigation"].load, rel=0.02)
    used = [one for one in shown["satellites"] if one["used"]]
    assert len(used) == shown["gnss"]["satellites_used"] > 8
    assert shown["solution"]["t_s"] == pytest.approx(30.0, abs=0.2)
    assert shown["link"]["garbage_bytes"] == shown["link"]["lost"] == shown["link"]["bad_crc"] == 0
    off = ("--seconds", "5", "--once", "--set", "profile.task_frames=false")
    assert last_line("car_mems", "--scenario", "static", *off)["tasks"] is None


@pytest.mark.parametrize("text", ["", "[]", '{"cpu": [{"tasks": 1}]}', '{"cpu": [{"tasks": [{"name": 1}]}]}'])
def test_task_load_of_a_run_that_did_not_tell_it(text, tmp_path):
    """The record of the run tells it for the whole run; a broken record tells nothing and breaks nothing."""
    writer = FrameWriter()
    said = solution(writer, 1.0) + writer.pack(STATUS, 1_000_000, 3, 0, *[1] * 7, 1, 1)
    write_capture(tmp_path / "run.mcap", [(1_000_000_000, said)])
    counts = {"activations": 5, "worst_response_us": 1234.5, "deadline_misses": 2}
    tasks = [{"name": "filter", "load": 0.125, **counts}]
    (tmp_path / "result.json").write_text(json.dumps({"cpu": [{"tasks": tasks}]}))
    told = monitor(str(tmp_path), "--once").stdout
    assert "whole run 12.5%  missed 2" in told
    assert "1234 µs" in told
    (tmp_path / "result.json").write_text(text)
    assert "task_frames = true" in monitor(str(tmp_path), "--once").stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["car_mem"], "did you mean 'car_mems'"),
        (["nothing.mcap"], "nothing.mcap"),
        (["car_mems", "--baud", "9600"], "--baud means nothing here: car_mems is a board"),
        (["/dev/ttyNoSuchPort"], "/dev/ttyNoSuchPort: there is no such port"),
        (["socket://127.0.0.1:1", "--speed", "2"], "--speed means nothing here"),
        (["socket://127.0.0.1:1", "--seed", "2"], "--seed means nothing here"),
        (["car_mems", "--scenario", "nowhere"], "no such scenario"),
        (["car_mems", "--once", "--size", "3x4000"], "--size 3x4000"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(arguments, words):
    result = monitor(*arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""


def test_a_foreign_file_and_an_empty_folder(tmp_path):
    (tmp_path / "notes.txt").write_text("words")
    assert "not a capture of navtwin" in monitor(str(tmp_path / "notes.txt")).stderr
    for size in (0, 5, 20, 100):
        (tmp_path / "short.mcap").write_bytes((b"\x89MCAP0\r\n" + bytes(100))[:size])
        result = monitor(str(tmp_path / "short.mcap"), "--once")
        assert result.exit_code == 2
        assert "not a capture of navtwin" in result.stderr
    (tmp_path / "folder").mkdir()
    assert "holds no run.mcap" in monitor(str(tmp_path / "folder")).stderr
    empty = CaptureWriter(tmp_path / "empty.mcap", manifest())
    empty.close({"state_hash": "0" * 64, "duration_s": "0.0"})
    result = monitor(str(tmp_path / "empty.mcap"), "--once")
    assert result.exit_code == 2
    assert "nothing to show" in result.stderr
