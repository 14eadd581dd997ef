"""What counts as worse, and what the files say when they do not fit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from host.baseline.comparison import Comparison, compared
from host.baseline.file import BaselineRun, parse_tolerance, read_baseline, write_baseline
from host.baseline.gated import direction
from host.record.errors import UserError

MANIFEST: dict[str, Any] = {
    "board": "car_mems",
    "scenario": "town",
    "scenario_text": "…",
    "overrides": [],
    "versions": {"navtwin": "0.1.0"},
}


def runs(values: list[float | None], figure: str = "yaw_rms_deg") -> list[BaselineRun]:
    return [
        BaselineRun("full-rate", (), seed, {"did_not_finish": 0.0, figure: value})
        for seed, value in enumerate(values)
    ]


def compare(
    tmp_path: Path, before: list[BaselineRun], now: list[BaselineRun], tolerance: float = 0.05
) -> Comparison:
    path = tmp_path / "baseline.json"
    write_baseline(path, MANIFEST, before)
    return compared(read_baseline(path), now, MANIFEST, tolerance)


def test_paired_differences_find_what_the_spread_of_seeds_hides(tmp_path: Path) -> None:
    """Seeds spread by 50 %; 10 % worse in every one of them is certain all the same."""
    before = (1.0 + 0.5 * np.random.default_rng(1).standard_normal(20)).tolist()
    found = compare(tmp_path, runs(before), runs([1.1 * value for value in before]))
    assert [one.figure for one in found.worse] == ["yaw_rms_deg"]
    assert not found.ok
    assert "+10.0 %" in str(found.section().rows)


def test_noise_without_a_shift_is_not_worse(tmp_path: Path) -> None:
    noise = 0.5 * np.random.default_rng(2).standard_normal(20)
    now = (1.06 + noise - noise.mean()).tolist()
    assert compare(tmp_path, runs([1.0] * 20), runs(now)).ok
    assert not compare(tmp_path, runs([1.0] * 20), runs([1.06] * 20)).ok


@pytest.mark.parametrize(("factor", "ok"), [(1.04, True), (1.06, False), (0.5, True)])
def test_tolerance_decides_a_single_run(tmp_path: Path, factor: float, ok: bool) -> None:
    found = compare(tmp_path, runs([2.0]), runs([2.0 * factor]))
    assert found.ok is ok
    assert found.differences[-1].low is None


def pairwise(
    tmp_path: Path, before: list[float], now: list[float], figure: str = "yaw_rms_deg"
) -> Comparison:
    return compare(tmp_path, runs([*before], figure), runs([*now], figure))


def test_two_seeds_that_are_both_worse_are_worse(tmp_path: Path) -> None:
    """The interval of two differences as unlike as these is 12 times as wide as their mean."""
    assert [one.figure for one in pairwise(tmp_path, [1.0, 1.0], [1.1, 3.0]).worse] == ["yaw_rms_deg"]


def test_what_more_seeds_would_tell_is_listed_and_never_called_good(tmp_path: Path) -> None:
    found = pairwise(tmp_path, [1.0, 1.0], [1.0, 1.5])
    assert [one.figure for one in found.unsure] == ["yaw_rms_deg"]
    assert "run more seeds" in found.verdict()
    assert "nothing is worse" not in found.verdict()
    assert [row[-1] for row in found.section().rows] == ["unsure"]
    assert [one["figure"] for one in found.to_dict()["unsure"]] == ["yaw_rms_deg"]


def test_what_never_happened_before_is_worse_when_it_happens_once(tmp_path: Path) -> None:
    for figure in ("deadline_misses", "overruns", "did_not_finish"):
        found = pairwise(tmp_path, [0.0] * 20, [0.0] * 19 + [1.0], figure)
        assert [one.figure for one in found.worse] == [figure]


def test_figures_that_the_first_run_lacks_are_compared(tmp_path: Path) -> None:
    failed = BaselineRun("full-rate", (), 0, {"did_not_finish": 1.0})
    before = [failed, *runs([1.0, 1.0, 1.0])[1:]]
    now = [failed, *runs([2.0, 2.0, 2.0])[1:]]
    (worse,) = compare(tmp_path, before, now).worse
    assert (worse.figure, worse.runs) == ("yaw_rms_deg", 2)


def test_run_that_used_to_fail_is_no_lost_figure(tmp_path: Path) -> None:
    failed = BaselineRun("full-rate", (), 0, {"yaw_rms_deg": 9.0, "did_not_finish": 1.0})
    found = compare(tmp_path, [failed, *runs([1.0, 1.0])[1:]], runs([50.0, 1.0]))
    assert found.ok
    assert [one.runs for one in found.differences if one.figure == "yaw_rms_deg"] == [1]


def test_order_of_swept_keys_is_no_other_setup(tmp_path: Path) -> None:
    before = BaselineRun("p", (("a", "1"), ("b", "2")), 1, {"yaw_rms_deg": 1.0, "did_not_finish": 0.0})
    now = BaselineRun("p", (("b", "2"), ("a", "1")), 1, {"yaw_rms_deg": 2.0, "did_not_finish": 0.0})
    assert [one.setup for one in compare(tmp_path, [before], [now]).worse] == ["p a=1 b=2"]


def test_less_availability_and_a_first_deadline_miss_are_worse(tmp_path: Path) -> None:
    found = compare(tmp_path, runs([1.0] * 3, "availability"), runs([0.9] * 3, "availability"))
    assert [one.figure for one in found.worse] == ["availability"]
    found = compare(tmp_path, runs([0.0], "deadline_misses"), runs([1.0], "deadline_misses"))
    assert [one.figure for one in found.worse] == ["deadline_misses"]


def test_figure_that_can_no_longer_be_computed_and_run_that_fails_are_worse(tmp_path: Path) -> None:
    assert not compare(tmp_path, runs([1.0, 1.0]), runs([1.0, None])).ok
    failed = BaselineRun("full-rate", (), 0, {"did_not_finish": 1.0})
    found = compare(tmp_path, runs([1.0]), [failed])
    assert [one.figure for one in found.worse] == ["did_not_finish"]


def test_equal_runs_are_neither_worse_nor_better(tmp_path: Path) -> None:
    found = compare(tmp_path, runs([1.0, 2.0]), runs([1.0, 2.0]), tolerance=0.0)
    assert found.ok
    assert found.section().rows == ()


def test_which_way_is_worse() -> None:
    assert direction("position_horizontal_rms_m") == 1
    assert direction("cpu.mcu.load") == 1
    assert direction("availability") == -1
    for name in ("gnss.position_horizontal_rms_m", "position_horizontal_max_m", "epochs", "nees_mean"):
        assert direction(name) == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [({"scenario": "static"}, "another scenario"), ({"scenario_text": "new"}, "text of the scenario"),
     ({"overrides": ["duration_s=5"]}, "another overrides"), ({"board": "gfsins"}, "another board")],
)  # fmt: skip
def test_baseline_of_something_else_is_refused(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    path = tmp_path / "baseline.json"
    write_baseline(path, MANIFEST, runs([1.0]))
    with pytest.raises(UserError, match=words):
        compared(read_baseline(path), runs([1.0]), {**MANIFEST, **change}, 0.05)


def test_runs_of_the_baseline_are_told_in_order(tmp_path: Path) -> None:
    other = [BaselineRun("thesis", (), 0, {"did_not_finish": 0.0})]
    with pytest.raises(UserError, match=r"full-rate seed 1, full-rate seed 2, .* seed 4 … .12 in all"):
        compare(tmp_path, runs([1.0] * 12), other)
    with pytest.raises(UserError, match=r"it has no runs$"):
        compare(tmp_path, [], other)


def test_no_common_run_is_told(tmp_path: Path) -> None:
    path = tmp_path / "baseline.json"
    write_baseline(path, MANIFEST, runs([1.0]))
    other = BaselineRun("thesis", (), 0, {"yaw_rms_deg": 1.0, "did_not_finish": 0.0})
    with pytest.raises(UserError, match="no run in common; it has full-rate seed 0"):
        compared(read_baseline(path), [other], MANIFEST, 0.05)


@pytest.mark.parametrize(
    ("text", "words"),
    [("{", "not valid JSON"), ("[]", "format None"), ('{"format": "navtwin-baseline-0"}', "baseline-0"),
     ('{"format": "navtwin-baseline-1"}', "not complete")],
)  # fmt: skip
def test_file_that_is_no_baseline(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "baseline.json"
    path.write_text(text)
    with pytest.raises(UserError, match=words):
        read_baseline(path)


LINE = '{"profile": "p", "set": {}, "seed": 1, "figures": {"yaw_rms_deg": 1.0, "did_not_finish": 0.0}}'


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [("1.0", "NaN", "not valid JSON"), ("1.0", "-Infinity", "not valid JSON"),
     ("1.0", "1e999", "yaw_rms_deg = inf"),
     ("1.0", '"1.0"', "must be a number or null"), ("1.0", "[1.0]", "must be a number or null"),
     ("1.0", "true", "must be a number or null"), (': 1, "f', ': "1", "f', "must be a whole number"),
     ('"p"', "3", "profile = 3 must be a text"), ("{}", "[1]", "make it anew"),
     ("0.0", "null", "must be 0 or 1"),
     ("0.0", "2", "must be 0 or 1"), (', "did_not_finish": 0.0', "", "'did_not_finish' is missing"),
     (LINE, f"{LINE}, {LINE}", "stands in it twice"), (LINE, "7", "make it anew")],
)  # fmt: skip
def test_figures_that_are_none_are_one_message(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / "baseline.json"
    head = '{"format": "navtwin-baseline-1", "board": "b", "scenario": "s", "scenario_digest": "d",'
    assert old in LINE
    path.write_text(f'{head} "overrides": [], "runs": [{LINE.replace(old, new)}]}}')
    with pytest.raises(UserError, match=words) as told:
        read_baseline(path)
    assert str(path) in str(told.value)


def test_figures_that_the_baseline_lacks_are_named(tmp_path: Path) -> None:
    now = [BaselineRun("full-rate", (), 0, {"did_not_finish": 0.0, "yaw_rms_deg": 1.0, "overruns": 3.0})]
    found = compare(tmp_path, runs([1.0]), now)
    assert "the baseline lacks them: overruns" in found.verdict()
    assert found.to_dict()["left_out"]
    assert "lacks them: yaw_rms_deg" in compare(tmp_path, runs([None]), runs([1.0])).verdict()
    assert not compare(tmp_path, runs([1.0]), runs([1.0])).left_out


def test_setups_that_only_one_of_the_two_has_are_named(tmp_path: Path) -> None:
    def run_of(profile: str, *swept: tuple[str, str]) -> BaselineRun:
        return BaselineRun(profile, swept, 0, {"did_not_finish": 0.0, "yaw_rms_deg": 1.0})

    before, now = [run_of("a"), run_of("b", ("k", "1"))], [run_of("a"), run_of("c")]
    verdict = compare(tmp_path, before, now).verdict()
    assert "in the baseline but not run: b k=1" in verdict
    assert "run but not in the baseline: c" in verdict


def test_baseline_file_has_a_run_a_line(tmp_path: Path) -> None:
    path = tmp_path / "baseline.json"
    write_baseline(path, MANIFEST, runs([1.0, 2.0]))
    assert sum('"seed"' in line for line in path.read_text().splitlines()) == 2
    assert json.loads(path.read_text())["board"] == "car_mems"


@pytest.mark.parametrize(("text", "share"), [("5%", 0.05), ("0.1", 0.1), ("0", 0.0), ("12.5%", 0.125)])
def test_tolerance(text: str, share: float) -> None:
    assert parse_tolerance(text) == pytest.approx(share)


@pytest.mark.parametrize("text", ["", "-1%", "five", "nan", "1e9"])
def test_tolerance_that_is_none(text: str) -> None:
    with pytest.raises(UserError, match="for example --tolerance 5%"):
        parse_tolerance(text)
