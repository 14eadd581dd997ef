"""Limits of a scenario: how they are read, complained about and judged."""

import pytest

from host.record.errors import UserError
from host.record.result import BusUse, CpuUse, FaultUse
from host.score.expectations import flat_figures, judge, parse_limits

CPU = CpuUse("mcu", 0.08, 2, 1, 4096, 0, ())
BUS = BusUse("spi1", 0.01, 120_000)
FAULT = FaultUse("cable", "uart-cut", "gnss", 100.0, 5.0, 3)
PARTS = {"cpu": ["mcu"], "buses": ["spi1"], "faults": ["cable"]}


def verdicts(expect, metrics=None, gnss=None):
    figures = flat_figures(metrics or {}, gnss or {}, [CPU], [BUS], [FAULT])
    return [(e.name, e.value, e.relation, e.limit, e.ok) for e in judge(parse_limits(expect, PARTS), figures)]


def test_a_bare_number_is_the_most_allowed():
    metrics = {"velocity_rms_mps": 0.1, "yaw_rms_deg": 1.51}
    assert verdicts({"velocity_rms_mps": 0.1, "yaw_rms_deg": 1.5}, metrics) == [
        ("velocity_rms_mps", 0.1, "<=", 0.1, True),
        ("yaw_rms_deg", 1.51, "<=", 1.5, False),
    ]


def test_of_availability_more_is_better():
    assert verdicts({"availability": 0.99}, {"availability": 0.98}) == [
        ("availability", 0.98, ">=", 0.99, False)
    ]


def test_a_range_is_two_limits():
    assert verdicts({"nees_mean": "4.5 .. 18"}, {"nees_mean": 20.0}) == [
        ("nees_mean", 20.0, ">=", 4.5, True),
        ("nees_mean", 20.0, "<=", 18.0, False),
    ]


def test_another_figure_as_the_limit():
    expect = {"position_horizontal_rms_m": "<= gnss.position_horizontal_rms_m"}
    figures = flat_figures({"position_horizontal_rms_m": 0.9}, {"position_horizontal_rms_m": 1.9})
    (found,) = judge(parse_limits(expect), figures)
    assert (found.ok, found.limit, found.limit_name) == (True, 1.9, "gnss.position_horizontal_rms_m")


def test_processors_buses_and_faults_have_figures():
    expect = {
        "cpu.mcu.load": 0.5,
        "deadline_misses": 0,
        "buses.spi1.load": "<= 1e-2",
        "faults.cable.fired": 1,
    }
    assert [row[-1] for row in verdicts(expect)] == [True, False, True, True]


def test_a_figure_that_could_not_be_computed_is_not_met():
    assert verdicts({"yaw_rms_deg": 1.5}, {"yaw_rms_deg": None}) == [("yaw_rms_deg", None, "<=", 1.5, False)]
    expect = {"yaw_rms_deg": "<= gnss.velocity_rms_mps"}
    assert not judge(parse_limits(expect), {"yaw_rms_deg": 1.0, "gnss.velocity_rms_mps": None})[0].ok


@pytest.mark.parametrize(
    ("expect", "message"),
    [
        ({"yaw_rms": 1.5}, r"expect.yaw_rms: no figure named 'yaw_rms'; did you mean 'yaw_rms_deg'\?"),
        ({"yaw_rms_deg": "< 3"}, r"expect.yaw_rms_deg = '< 3': not a limit; for example: yaw_rms_deg = 0.5"),
        ({"yaw_rms_deg": True}, "not a limit"),
        ({"yaw_rms_deg": float("nan")}, "not a limit"),
        (
            {"yaw_rms_deg": "<= gnss.position_horizontal"},
            "no figure named 'gnss.position_horizontal'; did you mean",
        ),
        ({"cpu.mcu2.load": 0.5}, r"did you mean 'cpu.mcu.load'\?"),
    ],
)
def test_wrong_limits_are_told_before_the_run(expect, message):
    with pytest.raises(UserError, match=message):
        parse_limits(expect, PARTS)
