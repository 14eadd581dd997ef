"""Limits of a scenario: how they are complained about and judged."""

from dataclasses import dataclass

import numpy as np
import pytest

from host.record.errors import UserError
from host.record.result import BusUse, CpuUse, FaultUse
from host.score.expectations import check_names, flat_figures, judge, with_solution_demanded
from host.score.recording_fit import FIGURES, RecordingFit

CPU = CpuUse("mcu", 0.08, 2, 1, 4096, 0, ())
BUS = BusUse("spi1", 0.01, 120_000)
FAULT = FaultUse("cable", "uart-cut", "gnss", 100.0, 5.0, 3)
PARTS = {"cpu": ["mcu"], "buses": ["spi1"], "faults": ["cable"]}


@dataclass
class Limit:
    relation: str
    value: float | None
    name: str | None = None


def verdicts(expect, metrics=None, gnss=None):
    check_names(expect, PARTS)
    figures = flat_figures(metrics or {}, gnss or {}, [CPU], [BUS], [FAULT])
    return [(e.name, e.value, e.relation, e.limit, e.ok) for e in judge(expect, figures)]


def test_limits_are_met_up_to_equality():
    metrics = {"velocity_rms_mps": 0.1, "yaw_rms_deg": 1.51, "availability": 0.98}
    expect = {
        "metrics.velocity_rms_mps": Limit("<=", 0.1),
        "yaw_rms_deg": Limit("<=", 1.5),
        "availability": Limit(">=", 0.99),
    }
    assert verdicts(expect, metrics) == [
        ("velocity_rms_mps", 0.1, "<=", 0.1, True),
        ("yaw_rms_deg", 1.51, "<=", 1.5, False),
        ("availability", 0.98, ">=", 0.99, False),
    ]


def test_another_figure_as_the_limit():
    expect = {"position_horizontal_rms_m": Limit("<=", None, "gnss.position_horizontal_rms_m")}
    figures = flat_figures({"position_horizontal_rms_m": 0.9}, {"position_horizontal_rms_m": 1.9})
    (found,) = judge(expect, figures)
    assert (found.ok, found.limit, found.limit_name) == (True, 1.9, "gnss.position_horizontal_rms_m")


def test_processors_buses_and_faults_have_figures():
    expect = {
        "cpu.mcu.load": Limit("<=", 0.5),
        "deadline_misses": Limit("<=", 0),
        "buses.spi1.load": Limit("<=", 1e-2),
        "faults.cable.fired": Limit(">=", 1),
        "faults_not_fired": Limit("<=", 0),
    }
    assert [row[-1] for row in verdicts(expect)] == [True, False, True, True, True]


def test_a_figure_that_could_not_be_computed_is_not_met():
    expect = {"yaw_rms_deg": Limit("<=", 1.5)}
    assert verdicts(expect, {"yaw_rms_deg": None}) == [("yaw_rms_deg", None, "<=", 1.5, False)]
    expect = {"yaw_rms_deg": Limit("<=", None, "gnss.velocity_rms_mps")}
    assert not judge(expect, {"yaw_rms_deg": 1.0, "gnss.velocity_rms_mps": None})[0].ok


@pytest.mark.parametrize(
    ("name", "limit_name", "message"),
    [
        (
            "yaw_rms",
            None,
            r"town: \[expect\] yaw_rms: no figure named 'yaw_rms'; did you mean 'yaw_rms_deg'\?",
        ),
        (
            "yaw_rms_deg",
            "gnss.position_horizontal",
            "no figure named 'gnss.position_horizontal'; did you mean",
        ),
        ("cpu.mcu2.load", None, r"did you mean 'cpu.mcu.load'\?"),
    ],
)
def test_unknown_figures_are_told_before_the_run(name, limit_name, message):
    with pytest.raises(UserError, match=message):
        check_names({name: Limit("<=", 1.0, limit_name)}, PARTS, "town")


def test_a_run_without_a_solution_meets_no_expectations_unless_they_speak_of_it():
    vacuous = {"deadline_misses": Limit("<=", 5)}
    demanded = with_solution_demanded(vacuous)
    assert [row[-1] for row in verdicts(demanded, {"seconds_with_solution": 0.0})] == [True, False]
    assert [row[-1] for row in verdicts(demanded, {"seconds_with_solution": 1.0})] == [True, True]
    outspoken = vacuous | {"metrics.availability": Limit("<=", 0.0)}
    assert with_solution_demanded(outspoken) == outspoken
    assert with_solution_demanded({}) == {}


def test_a_recordings_fit_can_be_expected_of():
    fit = RecordingFit()
    random = np.random.default_rng(5)
    level = np.tile([1.0, 0.0, 0.0, 0.0], (50, 1))
    fit.add(*(random.normal(size=(50, columns)) * 0.01 for columns in (12, 6, 3)), level)
    figures = flat_figures({}, {}, recording=fit.result())
    assert [name for name in figures if name.startswith("recording.")] == [f"recording.{f}" for f in FIGURES]
    assert all(figures[f"recording.{name}"] is not None for name in FIGURES)
    name = "recording.fused.after_position_horizontal_rms_m"
    limit = Limit("<=", None, "recording.gnss.after_position_horizontal_rms_m")
    check_names({name: limit}, PARTS, recording=True)
    (found,) = judge({name: limit}, figures)
    assert found.value == fit.result()["fused"]["after_position_horizontal_rms_m"]
    assert found.limit == fit.result()["gnss"]["after_position_horizontal_rms_m"]
    with pytest.raises(UserError, match="no figure named"):
        check_names({name: limit}, PARTS)
