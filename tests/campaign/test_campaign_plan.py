"""Seeds, swept values and quantities as the command line gives them."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from boards.description import load_board
from host.campaign.fault_plan import TARGETS, strikes
from host.campaign.plan import Plan, parse_changes, parse_seeds, parse_values, seeds_text
from host.campaign.quantities import FINDERS, quantity
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.faults import KINDS
from host.run.runner import check
from host.sim.gnss.faults import BASELINE_FAULT_KINDS, GNSS_FAULT_KINDS


@pytest.mark.parametrize(
    ("text", "seeds"),
    [("1-4", (1, 2, 3, 4)), ("7", (7,)), ("5,1-2,2", (1, 2, 5)), (" 3 - 4 , 9 ", (3, 4, 9)), ("0", (0,))],
)
def test_seeds(text: str, seeds: tuple[int, ...]) -> None:
    assert parse_seeds(text) == seeds


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "neither a seed"), ("9-3", "empty"), ("a", "neither"), ("-4", "neither"), ("1,,2", "neither"),
     ("4294967296", "at most 4294967295"), ("0-1000000", "more than"), ("1.5", "neither")],
)  # fmt: skip
def test_seeds_that_are_none(text: str, words: str) -> None:
    with pytest.raises(UserError, match=words) as told:
        parse_seeds(text)
    assert "for example" in str(told.value)


@given(st.sets(st.integers(0, 2**32 - 1), min_size=1, max_size=30))
def test_text_of_seeds_is_read_back(seeds: set[int]) -> None:
    ascending = tuple(sorted(seeds))
    assert parse_seeds(seeds_text(ascending)) == ascending


def test_values_split_at_outer_commas_only() -> None:
    assert parse_values("0.1, 0.2", "") == ("0.1", "0.2")
    assert parse_values("[1,2],[3,4]", "") == ("[1,2]", "[3,4]")
    assert parse_values('[{kind="a,b",at_s=1}]', "") == ('[{kind="a,b",at_s=1}]',)
    assert parse_values("1,true,'1'", "") == ("1", "true", "'1'"), "no two of them are the same"
    assert parse_values(f"1,{10**400}", "")[1] == str(10**400)
    assert parse_values("'x,y',z", "") == ("'x,y'", "z")


def test_changes_apart() -> None:
    fixed, swept = parse_changes(["gnss.latency_s=0.1,0.2", "duration_s=60", "imu.preset=bmi160,perfect"])
    assert fixed == ("duration_s=60",)
    assert swept == (("gnss.latency_s", ("0.1", "0.2")), ("imu.preset", ("bmi160", "perfect")))


@pytest.mark.parametrize(
    ("changes", "words"),
    [(["gnss.latency_s"], "key=value"), (["a=1,,2"], "missing"), (["a=1,1"], "given twice"),
     (["a=0.1,0.2,0.10"], "the value 0.1 is given twice, as 0.10"), (["a=1_000,1000.0"], "given twice"),
     (["a=1", "a=2"], "set twice")],
)  # fmt: skip
def test_changes_that_cannot_be(changes: list[str], words: str) -> None:
    with pytest.raises(UserError, match=words):
        parse_changes(changes)


def test_every_combination_once_in_order() -> None:
    swept = (("gnss.latency_s", ("0.1", "0.2")), ("imu.preset", ("bmi160", "perfect")))
    plan = Plan("car_mems", "static", ("full-rate", "thesis"), (1, 2, 9), ("duration_s=5",), swept)
    jobs = list(plan.jobs())
    assert len(jobs) == len(plan) == 2 * 2 * 2 * 3
    assert [job.number for job in jobs] == list(range(24))
    assert len({job.key for job in jobs}) == 24
    assert jobs[-1].request.overrides == ("duration_s=5", "gnss.latency_s=0.2", "imu.preset=perfect")
    assert (jobs[-1].request.profile, jobs[-1].request.seed) == ("thesis", 9)


def test_too_many_runs_are_refused() -> None:
    with pytest.raises(UserError, match="2,000,000 runs"):
        Plan("car_mems", "static", ("a", "b"), tuple(range(1_000_000)))


@pytest.mark.parametrize("name", FINDERS)
def test_quantities_lead_to_keys_of_the_board(name: str) -> None:
    found = quantity("car_mems", name)
    assert found is not None
    assert len(found.values) >= 5
    keys = {
        "bus-clock": "board.buses.spi1.clock_hz",
        "interrupt-latency": "board.processors.mcu.interrupt_entry_cycles",
        "sample-clock-error": "board.chips.U2.parameters.clock_error_ppm",
        "gnss-latency": "gnss.latency_s",
        "task-budget": "board.processors.mcu.costs.filter_update",
    }
    assert found.key == keys[name]


def test_quantity_of_a_part() -> None:
    found = quantity("car_mems", "task-budget:navigation_step")
    assert found is not None
    assert found.key == "board.processors.mcu.costs.navigation_step"
    with pytest.raises(UserError, match="no bus 'spi9'"):
        quantity("car_mems", "bus-clock:spi9")
    with pytest.raises(UserError, match="did you mean 'gnss-latency'"):
        quantity("car_mems", "gnss-latancy")
    assert quantity("car_mems", "gnss.position_white_m") is None


def test_every_kind_of_fault_has_its_targets() -> None:
    assert set(TARGETS) == {*KINDS, *GNSS_FAULT_KINDS}
    found = list(strikes(load_board("car_mems"), 10.0, 5.0))
    of_adis16407 = {"chip-halt", "chip-flags", "chip-supply"}
    no_i2c = {kind for kind in KINDS if kind.startswith("i2c-")}
    one_antenna = set(BASELINE_FAULT_KINDS)
    no_packets = {kind for kind in KINDS if kind.startswith("packet-")}
    no_twin_no_compass = {"spi-swapped", "chip-busy"}
    others = one_antenna | of_adis16407 | no_i2c | no_packets | no_twin_no_compass
    assert {strike.kind for strike in found} == set(TARGETS) - others
    assert {strike.target for strike in found if strike.kind == "chip-off"} == {"U2", "U3"}
    with pytest.raises(UserError, match="did you mean 'uart-cut'"):
        list(strikes(load_board("car_mems"), 10.0, 5.0, ["uart-cat"]))


EVERY_CHIP = str(Path(__file__).parent.parent / "run/every_chip")


@pytest.mark.parametrize(
    ("asked", "key"),
    [
        ("bus-clock", "board.buses.spi1.clock_hz"),
        ("bus-clock:spi2", "board.chips.U2.spi.clock_hz"),
        ("bus-clock:i2c1", "board.buses.i2c1.clock_hz"),
        ("sample-clock-error", "board.chips.U1.parameters.clock_error_ppm"),
        ("sample-clock-error:U3", "board.chips.U3.parameters.clock_error_ppm"),
        ("sample-clock-error:U4", "board.chips.U4.parameters.clock_error_ppm"),
    ],
)
def test_quantities_of_every_kind_of_chip(asked: str, key: str) -> None:
    found = quantity(EVERY_CHIP, asked)
    assert found is not None
    assert found.key == key
    check(RunRequest(EVERY_CHIP, None, None, 1, (f"{key}={found.values[1]}", "duration_s=1.0")))


def test_a_receiver_has_no_sample_clock() -> None:
    with pytest.raises(UserError, match="no chip U5"):
        quantity(EVERY_CHIP, "sample-clock-error:U5")
