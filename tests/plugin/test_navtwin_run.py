"""The fixture `navtwin_run`: marks, one run for equal requests, limits, and what a failure says."""

import shlex
import sys
import tomllib
import types
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from host.cli.main import app
from host.record.command_line import command_line, toml
from host.record.errors import UserError
from host.record.result import CpuUse, Expectation, FaultUse, RunRequest, RunResult

ROOT = Path(__file__).parents[2]


@pytest.fixture
def requests(monkeypatch):
    """Puts a runner in place that makes up figures; returns the requests it was given."""
    given_requests: list[RunRequest] = []

    def run(request: RunRequest) -> RunResult:
        given_requests.append(request)
        if request.scenario == "crash":
            raise ZeroDivisionError("in the firmware")
        if request.scenario == "nowhere":
            raise UserError("--scenario nowhere: no such scenario")
        figures = {
            "yaw_rms_deg": 0.25,
            "nees_mean": None,
            "seconds_with_solution": float(request.profile != "dead"),
        }
        expectations = (Expectation("yaw_rms_deg", 0.25, "<=", 1.5, True),)
        return RunResult(
            "tilt", "slope", "plain", request.seed, 60.0, 0.1, "", figures,
            {"position_horizontal_rms_m": 3.0}, cpu=(CpuUse("mcu", 0.125, 0, 0, 0, 0, ()),),
            faults=(FaultUse("cable", "uart-cut", "gnss", 1.0, None, 3),),
            expectations=() if request.scenario == "bare" else expectations, out_dir=request.out_dir,
        )  # fmt: skip

    module = types.ModuleType("host.run.runner")
    module.run = run  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "host.run.runner", module)
    return given_requests


def failure(call, *arguments, **more) -> str:
    """What a test that does this is told."""
    with pytest.raises((pytest.fail.Exception, AssertionError)) as told:
        call(*arguments, **more)
    assert told.value.__context__ is None, "a mistake is told once"
    return str(told.value)


@pytest.mark.navtwin("outer", seed=11, overrides={"a.b": 1, "c": 2})
class TestMarks:
    @pytest.mark.navtwin(
        scenario="slope", overrides={"c": "x", "d": True}, faults=[{"kind": "k", "at_s": 1.5}]
    )
    def test_the_nearest_goes_first_and_overrides_are_joined(self, navtwin_run, requests):
        navtwin_run(profile="plain")
        (request,) = requests
        assert (request.board, request.scenario, request.profile, request.seed) == (
            "outer",
            "slope",
            "plain",
            11,
        )
        fault = 'fault=[{"kind" = "k", "at_s" = 1.5}]'
        assert request.overrides == ("a.b=1", 'c="x"', "d=true", fault)
        assert request.capture is False
        assert request.out_dir is None

    def test_arguments_go_before_marks(self, navtwin_run, requests):
        navtwin_run("other", seed=12)
        assert (requests[0].board, requests[0].seed) == ("other", 12)

    def test_a_path_is_relative_to_the_rootdir(self, navtwin_run, requests, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        navtwin_run("boards/car_mems", scenario="boards/car_mems/scenarios/town.toml")
        assert requests[0].board == str(ROOT / "boards/car_mems")
        assert requests[0].scenario == str(ROOT / "boards/car_mems/scenarios/town.toml")


def test_a_folder_that_is_called_like_a_board_or_scenario_is_not_meant(navtwin_run, requests):
    navtwin_run("tests", scenario="docs")
    assert (requests[0].board, requests[0].scenario) == ("tests", "docs")


def test_equal_runs_are_made_once_in_a_session(navtwin_run, requests):
    first = navtwin_run("tilt", seed=21)
    assert navtwin_run("tilt", seed=21).result is first.result
    assert navtwin_run("tilt", seed=22).result is not first.result
    assert [request.seed for request in requests] == [21, 22]


def test_a_long_session_forgets_its_oldest_runs(navtwin_run, requests):
    for seed in range(100, 165):
        navtwin_run("tilt", seed=seed)
    navtwin_run("tilt", seed=164)
    assert len(requests) == 65
    navtwin_run("tilt", seed=100)
    assert len(requests) == 66


def test_figures_by_name(navtwin_run, requests):
    run = navtwin_run("tilt", seed=23)
    assert run["yaw_rms_deg"] == run["metrics.yaw_rms_deg"] == 0.25
    assert run["gnss.position_horizontal_rms_m"] == 3.0
    assert run["cpu.mcu.load"] == 0.125
    assert run["nees_mean"] is None
    assert "did you mean 'yaw_rms_deg'" in failure(run.__getitem__, "yaw_rms_degrees")


def test_limits_that_are_kept(navtwin_run, requests, request):
    run = navtwin_run("tilt", seed=24)
    assert run.expect() is run
    run.expect({"cpu.mcu.load": 0.125, "faults.cable.fired": ">= 3"}, yaw_rms_deg="<= 0.25")
    assert ("cpu.mcu.load", "0.125 <= 0.125") in request.node.user_properties


def test_a_limit_that_is_missed_tells_figure_value_limit_seed_and_command(navtwin_run, requests):
    run = navtwin_run("tilt", seed=25, scenario="slope", overrides={"gnss.latency_s": 0.1})
    told = failure(run.expect, {"cpu.mcu.load": 0.5}, yaw_rms_deg=0.2)
    assert "tilt slope plain seed 25: 1 of 3 expectations NOT MET" in told
    assert "OK       cpu.mcu.load           0.125, limit ≤ 0.5\n" in told
    assert "NOT MET  yaw_rms_deg            0.250, limit ≤ 0.2  (exact: 0.25 <= 0.2)" in told
    assert "\nseed: 25\n" in told
    command = told.partition("reproduce: ")[2]
    assert command == (
        "navtwin run tilt --scenario slope --seed 25 --set gnss.latency_s=0.1"
        """ --set 'expect={"cpu.mcu.load" = 0.5, "yaw_rms_deg" = 0.2}'"""
    )
    assert run.command == command.rpartition(" --set ")[0]


def test_a_board_without_a_solution_keeps_no_limit(navtwin_run, requests):
    run = navtwin_run("tilt", profile="dead")
    assert "NOT MET  seconds_with_solution" in failure(run.expect, deadline_misses=0)
    run.expect(deadline_misses=0, seconds_with_solution=0)


def test_a_figure_that_could_not_be_computed_keeps_no_limit(navtwin_run, requests):
    assert "NOT MET  nees_mean" in failure(navtwin_run("tilt", seed=26).expect, nees_mean=18.0)


@pytest.mark.parametrize(("wanted", "message"), [
    ({"yaw_rms": 1.0}, "no figure named 'yaw_rms'; did you mean 'yaw_rms_deg'"),
    ({"yaw_rms_deg": "< 1.0"}, 'must be a number or a text like "<= 2.5"'),
    ({"yaw_rms_deg": True}, "must be a number"),
    ({"cpu.brain.load": 0.5}, "no figure named 'cpu.brain.load'"),
])  # fmt: skip
def test_a_limit_that_cannot_be_is_told(navtwin_run, requests, wanted, message):
    assert message in failure(navtwin_run("tilt", seed=27).expect, wanted)


def test_a_scenario_that_expects_nothing_passes_no_test(navtwin_run, requests):
    assert "has no [expect]" in failure(navtwin_run("tilt", scenario="bare").expect)


@pytest.mark.parametrize(("wanted", "message"), [
    ({}, "no board; for example"),
    ({"board": "tilt", "sead": 1}, "sead = 1: no such setting of a run; did you mean 'seed'"),
    ({"board": "tilt", "seed": 1.5}, "seed = 1.5: must be a whole number"),
    ({"board": "tilt", "overrides": ["a=1"]}, "must be a dict"),
    ({"board": "tilt", "overrides": {"a": None}}, "None: a NoneType cannot be given"),
    ({"board": "tilt", "scenario": "nowhere"}, "navtwin_run: --scenario nowhere: no such scenario"),
])  # fmt: skip
def test_a_run_that_cannot_be_is_told(navtwin_run, requests, wanted, message):
    assert message in failure(navtwin_run, **wanted)


def test_a_crash_in_the_firmware_keeps_its_traceback_and_tells_the_command(navtwin_run, requests):
    with pytest.raises(ZeroDivisionError) as told:
        navtwin_run("tilt", scenario="crash", seed=28)
    assert told.value.__notes__ == ["seed 28\nreproduce: navtwin run tilt --scenario crash --seed 28"]


# -- the command line ------------------------------------------------------------------------------

WORDS = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc")), min_size=1, max_size=8)
VALUES = st.recursive(
    st.booleans() | st.integers(-(2**62), 2**62) | st.floats(allow_nan=False, allow_infinity=False) | WORDS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3),
    max_leaves=8,
)


@given(VALUES)
def test_a_value_is_the_same_after_toml(value):
    assert tomllib.loads(f"value = {toml(value)}")["value"] == value


@given(
    st.sampled_from([None, "slope", "./my drive.toml"]),
    st.sampled_from([None, "plain"]),
    st.integers(0, 2**32),
    st.dictionaries(st.sampled_from(["a.b", "board.x", "profile.y"]), VALUES, max_size=3),
)
def test_the_command_asks_for_the_same_run(scenario, profile, seed, overrides):
    changes = tuple(f"{key}={toml(value)}" for key, value in overrides.items())
    request = RunRequest("car_mems", scenario, profile, seed, changes)
    program, *words = shlex.split(command_line(request))
    assert program == "navtwin"
    asked: list[RunRequest] = []

    def execute(request, outputs):
        asked.append(request)
        return 0

    module = types.ModuleType("host.cli.run_command")
    module.execute = execute  # type: ignore[attr-defined]
    module.Outputs = lambda *_, **__: None  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "host.cli.run_command", module)
        assert CliRunner().invoke(app, words).exit_code == 0
    assert asked == [request]
