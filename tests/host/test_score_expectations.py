"""Limits of a scenario: how they are complained about and judged."""

from dataclasses import dataclass

import pytest

from host.record.errors import UserError
from host.record.result import BusUse, CpuUse, FaultUse
from host.score.expectations import check_names, flat_figures, judge

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
