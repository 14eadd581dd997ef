"""`navtwin sweep` and `navtwin faults`."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import can
import numpy as np
from campaign_rig import REST, navtwin

from host.campaign.fault_effect import Effect, effect, fault_course
from host.campaign.fault_plan import Strike
from host.campaign.fault_sheet import section, sheet_csv, verdict
from host.record.can_course import CanCourse
from host.record.result import BusUse, Event, FaultUse, RunRequest, RunResult
from host.record.run_data import STATUS_COLUMNS, RunData
from host.record.series import DecimatedSeries
from host.record.tables import SOLUTION
from host.run.runner import run

REQUEST = RunRequest("car_mems", str(REST), overrides=("duration_s=20",), capture=False)


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_slower_processor_work_shows_in_load_and_deadline_misses(tmp_path: Path) -> None:
    out = tmp_path / "s"
    result = navtwin(
        *("sweep", "car_mems", "--key", "task-budget:navigation_step", "--values", "5200,520000,2000000"),
        *("-s", REST, "--set", "duration_s=30", "--seeds", "1-2", "--out", out, "-q"),
    )
    assert result.exit_code == 0, result.output
    key = "board.processors.mcu.costs.navigation_step"
    curves = [row for row in read_csv(out / "curves.csv") if row["figure"] == "cpu.mcu.load"]
    loads = {row[key]: float(row["mean"]) for row in curves}
    assert loads["520000"] - loads["5200"] > 0.8 * (520_000 - 5_200) * 100 * 20 / 30 / 168e6
    misses = {
        row[key]: float(row["mean"])
        for row in read_csv(out / "curves.csv")
        if row["figure"] == "deadline_misses"
    }
    assert misses["5200"] == 0 < misses["2000000"]
    assert f"Errors against {key}" in (out / "report.html").read_text()


def test_interrupt_latency_is_in_the_response_times(tmp_path: Path) -> None:
    out = tmp_path / "s"
    result = navtwin(
        *("sweep", "car_mems", "-k", "interrupt-latency", "--values", "12,252000", "-s", REST),
        *("--set", "duration_s=20", "--seeds", "1", "--out", out, "-q"),
    )
    assert result.exit_code == 0, result.output
    misses = [row for row in read_csv(out / "curves.csv") if row["figure"] == "deadline_misses"]
    assert float(misses[0]["mean"]) == 0
    assert float(misses[1]["mean"]) > 100, "1.5 ms late, with a deadline of 1 ms for the sensor's interrupt"


def test_sweep_that_cannot_be(tmp_path: Path) -> None:
    for arguments, words in (
        (("--key", "bus-clok"), "did you mean 'bus-clock'"),
        (("--key", "gnss.latency_s"), "needs --values"),
        (("--key", "gnss.latency_s", "--values", "0.1"), "two values at least"),
        (("--key", "bus-clock", "--values", "1000000,fast"), "clock_hz"),
        (("--key", "bus-clock", "--set", "gnss.latency_s=0.1,0.2"), "one key"),
    ):
        result = navtwin("sweep", "car_mems", *arguments, "-s", REST, "--out", tmp_path / "s")
        assert result.exit_code == 2, arguments
        assert words in result.stderr
        assert result.stderr.count("\n") == 1


def test_fault_sheet_of_some_faults(tmp_path: Path) -> None:
    out = tmp_path / "f"
    asked = ("--only", "uart-cut,chip-off,cpu-reset", "--at", 40, "--for", 4, "--out", out)
    result = navtwin("faults", "car_mems", "-s", REST, *asked)
    assert result.exit_code == 1, result.output
    sheet = {(row["fault"], row["target"]): row for row in read_csv(out / "faults.csv")}
    assert list(sheet) == [("uart-cut", "gnss"), ("chip-off", "U2"), ("chip-off", "U3"), ("cpu-reset", "mcu")]
    assert all(int(row["fired"]) > 0 for row in sheet.values())
    silent = sheet.pop(("chip-off", "U2"))
    assert silent["verdict"] == "not recovered", "at rest nothing shows the heading that was lost meanwhile"
    assert float(silent["worst_attitude_error_deg"]) > float(silent["usual_attitude_error_deg"]) + 3
    assert all(row["verdict"] == "recovered" for row in sheet.values())
    assert sheet["uart-cut", "gnss"]["said"].startswith("GNSS lost")
    assert 1 < float(sheet["uart-cut", "gnss"]["detected_after_s"]) < 4
    assert float(sheet["cpu-reset", "mcu"]["without_solution_s"]) > 2
    assert "3 of 4 faults struck" in (out / "faults.html").read_text()


def test_what_can_frames_suffer_is_a_figure(tmp_path: Path) -> None:
    """Ten sets of five frames a second; what waits in the controller's mailboxes meanwhile comes late."""
    out = tmp_path / "f"
    asked = ("--only", "can-disturbance", "--at", 40, "--for", 5, "--out", out)
    result = navtwin("faults", "car_mems", "-s", REST, *asked)
    assert result.exit_code == 0, result.output
    (row,) = read_csv(out / "faults.csv")
    assert row["verdict"] == "recovered"
    assert abs(int(row["can_frames_expected"]) / (5 * 10 * 50) - 1) < 0.01
    missing = int(row["can_frames_expected"]) - int(row["can_frames"])
    assert 5 * 50 - 16 <= missing < 5 * 50
    assert 5.0 < float(row["longest_can_gap_s"]) < 5.3
    assert abs(float(row["usual_can_gap_s"]) - 0.1) < 0.01
    assert int(row["can_errors"]) == int(row["fired"]) > 0
    assert row["said"].startswith("STATUS: frames_dropped")
    assert 5.0 <= float(row["recovered_after_s"]) <= 6.0
    assert f"CAN: {missing} of {row['can_frames_expected']} frames missing" in row["effect"]


def test_faults_that_cannot_be(tmp_path: Path) -> None:
    for arguments, words in (
        (("--only", "uart-cat"), "did you mean 'uart-cut'"),
        (("--at", 1e6, "--only", "uart-cut"), "not before the end of the run"),
        (("--for", 0), "must be above 0 s"),
    ):
        result = navtwin("faults", "car_mems", "-s", REST, *arguments, "--out", tmp_path / "f")
        assert result.exit_code == 2, arguments
        assert words in result.stderr
        assert result.stderr.count("\n") == 1


STRIKE = Strike("uart-cut", "gnss", 100.0, 10.0)


def made_up(
    bad: tuple[float, float] | None, gap: tuple[float, float] | None = None, told: bool = True
) -> RunResult:
    """200 s at 10 Hz with 1 m of error; 20 m in `bad`, nothing in `gap`."""
    t = np.arange(0.0, 200.0, 0.1)
    rows = np.zeros((len(t), len(SOLUTION.columns)))
    rows[:, 0] = t
    rows[:, SOLUTION.columns.index("mode")] = 3
    east = SOLUTION.columns.index("error_east_m")
    rows[:, east] = 1.0
    rows[:, SOLUTION.columns.index("latitude_deg")] = 30.0
    if bad is not None:
        rows[(t >= bad[0]) & (t < bad[1]), east] = 20.0
    if gap is not None:
        rows = rows[(t < gap[0]) | (t >= gap[1])]
    data = RunData(
        solution=DecimatedSeries(SOLUTION.columns, 4096),
        **{name: DecimatedSeries(("t_s",), 2) for name in ("gnss", "innovations", "biases")},
    )
    data.solution.add(rows)
    events = [Event(50.0, "board", "mode: navigating"), Event(150.0, "board", "usual")]
    if told:
        events.insert(1, Event(102.5, "board", "GNSS lost"))
    fault = FaultUse("f", "uart-cut", "gnss", 100.0, 10.0, 3)
    return RunResult(
        *("b", "s", "p", 1, 200.0, 1.0, "hash", {}, {}), faults=(fault,), events=tuple(events), data=data
    )


def seen(result: RunResult) -> Effect:
    return effect(STRIKE, fault_course(result), fault_course(made_up(None, told=False)))


def test_effect_is_measured_from_the_strike() -> None:
    found = seen(made_up((104.0, 112.0)))
    assert (found.fired, found.detected_after_s, found.said) == (3, 2.5, "GNSS lost")
    assert (found.worst, found.usual) == ((20.0, None, None), (1.0, None, None))
    assert found.recovered_after_s is not None
    assert abs(found.recovered_after_s - 12.0) < 0.11
    assert (found.without_solution_s, found.verdict) == (0.0, "recovered")


def test_gap_counts_until_its_end() -> None:
    found = seen(made_up(None, (105.0, 109.0)))
    assert abs(found.without_solution_s - 4.1) < 0.11
    assert found.recovered_after_s is not None
    assert abs(found.recovered_after_s - 9.0) < 0.11


def test_verdicts() -> None:
    assert seen(made_up((104.0, 300.0))).verdict == "not recovered"
    assert seen(made_up(None, (180.0, 300.0))).verdict == "not recovered"
    assert seen(made_up((104.0, 112.0), told=False)).verdict == "not told"
    unseen = seen(made_up(None, told=False))
    assert (unseen.verdict, unseen.ok) == ("not observed", True)
    assert sheet_csv([unseen]).splitlines()[1].count(",no effect,") == 1
    assert section([unseen]).rows[0][-1] == "no effect"
    assert verdict([unseen]).startswith("0 of 1 faults struck and were recovered from")
    assert verdict([unseen]).endswith("1 without an effect to be seen")
    course = fault_course(made_up(None)) | {"fired": [0]}
    never = effect(STRIKE, json.loads(json.dumps(course)), fault_course(made_up(None)))
    assert (never.verdict, never.ok) == ("did not strike", False)
    assert verdict([never]) == "0 of 1 faults struck and were recovered from; the board told of 0"


def with_events(*more: Event) -> RunResult:
    quiet = made_up((104.0, 112.0), told=False)
    return replace(quiet, events=(*quiet.events, *more))


def test_a_fault_that_changes_no_solution_is_over_when_the_board_says_so() -> None:
    told = made_up(None)
    only = seen(told)
    assert (only.verdict, only.recovered_after_s, only.ok) == ("told only", None, True)
    over = seen(replace(told, events=(*told.events, Event(111.0, "board", "GNSS is back"))))
    assert (over.verdict, over.recovered_after_s) == ("recovered", 11.0)


def test_only_words_about_the_fault_count_as_told() -> None:
    assert seen(with_events(Event(190.0, "board", "low battery"))).verdict == "not told"
    usual = replace(made_up(None, told=False), events=(Event(105.0, "board", "17 frames lost"),))
    there = fault_course(replace(with_events(), events=(Event(105.1, "board", "18 frames lost"),)))
    assert effect(STRIKE, there, fault_course(usual)).verdict == "not told"


def with_can(
    course: tuple[list[int], list[float]], errors: int = 0, counted: tuple[float, int] | None = None
) -> RunResult:
    """200 s with frames in each second; frames_dropped rises by so many at the end of a second."""
    frames, gaps = course
    result = made_up(None, told=False)
    assert result.data is not None
    result.data.can.append(CanCourse("can1", 0x310, np.array(frames), np.array(gaps)))
    status = np.zeros((200, len(STATUS_COLUMNS)))
    status[:, 0] = np.arange(200) + 0.9
    if counted is not None:
        status[status[:, 0] >= counted[0], STATUS_COLUMNS.index("frames_dropped")] = counted[1]
    result.data.status.add(status)
    return replace(result, buses=(BusUse("can1", 0.1, sum(frames), errors=errors),))


USUAL_FRAMES, USUAL_GAPS = [10] * 200, [0.1] * 200


def against_usual(there: RunResult) -> Effect:
    return effect(STRIKE, fault_course(there), fault_course(with_can((USUAL_FRAMES, USUAL_GAPS))))


def test_can_frames_that_do_not_come_again_are_not_recovered() -> None:
    frames = [10] * 100 + [0] * 100
    gaps = [0.1] * 100 + [0.0] * 99 + [100.0]
    found = against_usual(with_can((frames, gaps), errors=32, counted=(101.0, 7)))
    assert found.can is not None
    assert (found.can.expected, found.can.came, found.can.errors) == (1000, 0, 32)
    assert found.can.longest_gap_s == 100.0
    assert (found.verdict, found.recovered_after_s) == ("not recovered", None)
    assert found.detected_after_s is not None
    assert abs(found.detected_after_s - 1.9) < 1e-9
    assert found.said == "STATUS: frames_dropped +7"


def test_fewer_can_frames_without_a_gap_count_until_they_all_come() -> None:
    frames = [10] * 100 + [5] * 10 + [10] * 90
    found = against_usual(with_can((frames, USUAL_GAPS)))
    assert (found.verdict, found.recovered_after_s) == ("not told", 10.0)
    shifted = against_usual(with_can(([10] * 100 + [9, 11] * 50, USUAL_GAPS)))
    assert (shifted.can is not None and shifted.can.differs, shifted.verdict) == (False, "not observed")


def test_counters_that_rise_long_after_the_fault_do_not_tell_of_it() -> None:
    found = against_usual(with_can((USUAL_FRAMES, USUAL_GAPS), counted=(150.0, 7)))
    assert (found.detected_after_s, found.verdict) == (None, "not observed")


def test_the_rhythm_on_can_is_that_of_the_capture(tmp_path: Path) -> None:
    """The course kept of each identifier against the frames of the capture, by python-can's reader."""
    asked = replace(REQUEST, out_dir=tmp_path / "r", capture=True)
    result = run(asked)
    assert result.data is not None
    log = tmp_path / "can.log"
    exported = navtwin("capture", "export", tmp_path / "r" / "run.mcap", "--format", "candump", "-o", log)
    assert exported.exit_code == 0, exported.output
    messages = list(can.CanutilsLogReader(log))
    assert {course.identifier for course in result.data.can} == {one.arbitration_id for one in messages}
    for course in result.data.can:
        times = [one.timestamp for one in messages if one.arbitration_id == course.identifier]
        np.testing.assert_array_equal(course.frames, np.bincount(np.int64(times), minlength=20))
        longest = np.diff([0.0, *times, 20.0]).max()
        assert abs(course.gaps.max() - longest) < 2e-6
    plain = run(REQUEST).data
    assert plain is not None
    for one, other in zip(plain.can, result.data.can, strict=True):
        np.testing.assert_array_equal(one.gaps, other.gaps)


def test_lost_attitude_of_a_board_without_position_is_not_recovered() -> None:
    """Zeros stand for a position that the board does not know: its error of 5,000 km says nothing."""

    def tilted(lost_from_s: float) -> dict[str, object]:
        result = made_up(None)
        assert result.data is not None
        rows = np.stack([result.data.solution.column(name) for name in SOLUTION.columns], axis=1)
        place = SOLUTION.columns.index
        rows[:, place("latitude_deg")] = 0.0
        rows[:, place("error_east_m")] = 5e6
        rows[:, place("roll_deg")] = 1.0
        rows[:, place("error_roll_deg")] = np.where(rows[:, 0] < lost_from_s, 0.5, 40.0)
        solution = DecimatedSeries(SOLUTION.columns, 4096)
        solution.add(rows)
        return fault_course(replace(result, data=replace(result.data, solution=solution)))

    lost = effect(STRIKE, tilted(105.0), tilted(1e9))
    assert (lost.verdict, lost.worst, lost.usual) == ("not recovered", (None, None, 40.0), (None, None, 0.5))
