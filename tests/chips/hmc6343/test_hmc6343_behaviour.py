"""Headings, orientations, modes, EEPROM, filter, calibration, data ready, against the bench's rotations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hmc6343_rig import ADDRESS, DOWN, HORIZONTAL, MS, SECOND, US, Rig
from hypothesis import given, settings
from hypothesis import strategies as some

from hal.errors import BusError

ORIENTATION_COMMANDS = {"level": 0x72, "edge": 0x73, "front": 0x74}
ORIENTATION_BITS = {"level": 0x01, "edge": 0x02, "front": 0x04}


def turned(tenths: int, other: int) -> int:
    """Difference of two headings."""
    return (tenths - other + 1800) % 3600 - 1800


@given(
    some.sampled_from(sorted(ORIENTATION_COMMANDS)),
    some.floats(0.0, 359.9),
    some.floats(-60.0, 60.0),
    some.floats(-60.0, 60.0),
)
@settings(max_examples=60, deadline=None)
def test_heading_pitch_and_roll(orientation: str, heading: float, pitch: float, roll: float) -> None:
    rig = Rig(lambda t: (heading, pitch, roll), mounting=orientation)
    rig.start()
    rig.command(ORIENTATION_COMMANDS[orientation], delay_ns=300 * US)
    found = rig.words(0x50)
    assert abs(turned(found[0], round(heading * 10))) <= 1
    assert 0 <= found[0] < 3600
    assert found[1:] == pytest.approx([pitch * 10, roll * 10], abs=0.51)
    assert rig.words(0x55)[:2] == found[1:]
    assert rig.ask(0x65, length=1)[0] & 0x17 == 0x10 | ORIENTATION_BITS[orientation]
    assert rig.details == []


def test_deviation_and_variation_are_added() -> None:
    rig = Rig(lambda t: (355.0, 0.0, 0.0))
    rig.start()
    for address, tenths in ((0x0A, 23), (0x0C, -5)):
        rig.poke(address, tenths & 0xFF)
        rig.poke(address + 1, tenths >> 8 & 0xFF)
    rig.reset()
    assert rig.words(0x50)[0] == 3550 + 23 - 5
    rig.poke(0x0C, 100)
    rig.poke(0x0D, 0)
    rig.reset()
    assert rig.words(0x50)[0] == (3550 + 23 + 100) % 3600


# -- modes -----------------------------------------------------------------------------------------


def test_standby_holds_and_run_goes_on() -> None:
    rig = Rig(lambda t: (10.0 * t % 360.0, 0.0, 0.0))
    rig.start()
    rig.command(0x76, delay_ns=300 * US)
    held = rig.words(0x50)
    assert rig.ask(0x65, length=1)[0] & 0x18 == 0x08
    rig.wait(5 * SECOND)
    assert rig.words(0x50) == held
    rig.command(0x75, delay_ns=300 * US)
    began = rig.time.now
    rig.wait(190 * MS)
    assert rig.words(0x50) == held
    rig.until(began + 205 * MS)
    assert abs(turned(rig.words(0x50)[0], round(began * 1e-7 + 20))) <= 2


def test_sleep_accepts_only_waking() -> None:
    rig = Rig()
    rig.start()
    rig.command(0x83)
    assert rig.ask(0x50) == b"\xff" * 6
    assert rig.details[0] == "post heading in sleep: ignored"
    rig.command(0x84, delay_ns=20 * MS)
    assert rig.ask(0x65, length=1)[0] & 0x18 == 0x08
    rig.command(0x75, delay_ns=300 * US)
    rig.wait(250 * MS)
    assert rig.words(0x50)[0] == 300


def test_power_up_lands_in_the_stored_mode() -> None:
    rig = Rig()
    rig.start()
    rig.poke(0x04, 0x08 | 0x02)
    assert rig.ask(0x65, length=1)[0] == 0x11
    rig.chip.brownout()
    rig.wait(501 * MS)
    assert rig.ask(0x65, length=1)[0] == 0x0A
    assert rig.ask(0x50) == bytes(6)


# -- EEPROM ----------------------------------------------------------------------------------------

FACTORY = {0x00: 0x32, 0x04: 0x11, 0x05: 0x01} | dict.fromkeys(range(0x0A, 0x16), 0x00)


@pytest.mark.parametrize(("address", "value"), FACTORY.items())
def test_factory_values(address: int, value: int) -> None:
    rig = Rig()
    rig.start()
    assert rig.peek(address) == value
    assert rig.details == []


def test_serial_number() -> None:
    rig = Rig(serial_number=0xBEEF)
    rig.start()
    assert (rig.peek(0x06), rig.peek(0x07)) == (0xEF, 0xBE)


@pytest.mark.parametrize("address", range(0x0A, 0x15))
def test_words_are_kept_over_power(address: int) -> None:
    rig = Rig()
    rig.start()
    rig.poke(address, 0x0B)
    rig.chip.brownout()
    rig.wait(501 * MS)
    assert rig.peek(address) == 0x0B
    assert rig.details == []


@pytest.mark.parametrize(
    ("address", "value"),
    [
        (0x01, 1),
        (0x02, 9),
        (0x03, 1),
        (0x06, 9),
        (0x08, 9),
        (0x16, 1),
        (0xFF, 1),
        (0x00, 0x0F),
        (0x05, 3),
        (0x05, 4),
    ],
)
def test_what_users_must_not_write(address: int, value: int) -> None:
    rig = Rig()
    rig.start()
    rig.poke(address, value)
    assert len(rig.details) == 1
    assert rig.peek(address) != value


def test_read_only_bits_of_op_mode_1() -> None:
    rig = Rig()
    rig.start()
    rig.poke(0x04, 0xD1)
    assert rig.peek(0x04) == 0x11


def test_a_new_address_counts_from_the_reset_on() -> None:
    rig = Rig()
    rig.start()
    rig.poke(0x00, 0x40)
    assert rig.peek(0x00) == 0x40
    rig.bus.transaction(ADDRESS, b"\x82")
    rig.wait(501 * MS)
    with pytest.raises(BusError):
        rig.bus.transaction(ADDRESS, b"\x50")


# -- rate and data ready ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("code", "rate_hz", "least_low_ns"), [(0, 1, 750_000), (1, 5, 150_000), (2, 10, 75_000)]
)
def test_rate_and_data_ready(code: int, rate_hz: int, least_low_ns: int) -> None:
    rig = Rig(clock_error_ppm=200.0)
    rig.start()
    rig.poke(0x05, code)
    edges: list[tuple[int, bool]] = []
    rig.net.listen(lambda level, when: edges.append((when, level)))
    rig.wait(1 * SECOND)
    assert np.diff([when for when, level in edges if level])[-1] == pytest.approx(SECOND / 5 / 1.0002, abs=2)
    rig.bus.transaction(ADDRESS, b"\x82")
    answers = rig.time.now - 10 * US + 500 * MS
    del edges[:]
    rig.until(answers + 4 * SECOND)
    highs = [when for when, level in edges if level]
    lows = [when for when, level in edges if not level]
    assert highs[0] == answers
    assert np.diff(highs) == pytest.approx(SECOND / rate_hz / 1.0002, abs=2)
    assert all(high - low > least_low_ns for low, high in zip(lows, highs[1:], strict=False))
    assert rig.details == []


def test_no_event_without_a_listener() -> None:
    rig = Rig()
    rig.start()
    events = rig.time.events_run
    rig.wait(100 * SECOND)
    assert rig.time.events_run - events <= 1  # the bench's own wait
    rig.words(0x50)
    assert rig.world.calls <= 2


def test_computing_bit_before_a_measurement() -> None:
    rig = Rig()
    rig.until(500 * MS + 200 * MS - 300 * US)
    assert rig.ask(0x65, length=1)[0] == 0x91


# -- filter ----------------------------------------------------------------------------------------


def test_filter_weighs_newest_and_previous() -> None:
    """A step by 60° between two measurements at 5 Hz: with N = 4 it comes through over five of them."""
    rig = Rig(lambda t: (350.0 if t < 3.5 else 50.0, 0.0, 0.0))
    rig.start()
    rig.poke(0x14, 4)
    rig.poke(0x04, 0x31)
    rig.reset()
    assert rig.ask(0x65, length=1)[0] & 0x20
    rig.until(3_400 * MS)
    passed = []
    for _ in range(8):
        passed.append(turned(rig.words(0x50)[0], 3500) / 600.0)
        rig.wait(198 * MS)
    assert passed[0] == 0.0
    steps = np.diff([value for value in passed if value > 0.0])
    assert passed[-1] == 1.0
    assert len([value for value in passed if 0.0 < value < 1.0]) == 4
    assert (np.diff([0.0, *[value for value in passed if value > 0.0]])[:5] > 0.0).all()
    assert steps[0] > steps[1] > steps[2] > steps[3]


def test_without_the_filter_bit_the_value_does_nothing() -> None:
    rig = Rig(lambda t: (350.0 if t < 3.5 else 50.0, 0.0, 0.0))
    rig.start()
    rig.poke(0x14, 4)
    rig.reset()
    rig.until(3_900 * MS)
    assert rig.words(0x50)[0] == 500


# -- calibration -----------------------------------------------------------------------------------


def tumbling(t: float) -> tuple[float, float, float]:
    """From 1 s on a turn about the vertical, from 21 s on one about the fore-aft axis, then rest."""
    if t < 1.0:
        return 30.0, 0.0, 0.0
    if t < 21.0:
        return (30.0 + (t - 1.0) * 18.0) % 360.0, 0.0, 0.0
    return 30.0, 0.0, min((t - 21.0) * 18.0, 360.0)


@pytest.mark.parametrize(("enter", "leave"), [(0x71, 0x7E), (0x70, 0x7F)])
def test_calibration_takes_hard_iron_out(enter: int, leave: int) -> None:
    rig = Rig(tumbling, iron=(120.0, -80.0, 60.0))
    rig.start()
    wrong = rig.words(0x50)[0]
    assert abs(turned(wrong, 300)) > 100
    rig.command(enter, delay_ns=300 * US)
    assert rig.ask(0x65, length=1)[0] & 0x40
    rig.until(42 * SECOND)
    rig.command(leave, delay_ns=50 * MS)
    assert rig.ask(0x65, length=1)[0] & 0x40 == 0
    rig.wait(1 * SECOND)
    assert abs(turned(rig.words(0x50)[0], 300)) <= 10
    offsets = [
        int.from_bytes(bytes((rig.peek(at), rig.peek(at + 1))), "little", signed=True)
        for at in (0x0E, 0x10, 0x12)
    ]
    assert offsets == pytest.approx([-1200, 800, -600], abs=15)
    field = rig.words(0x45)
    assert field == pytest.approx(
        [10 * HORIZONTAL * np.cos(np.radians(30)), 10 * HORIZONTAL * np.sin(np.radians(30)), -10 * DOWN],
        abs=20,
    )
    rig.reset()
    assert abs(turned(rig.words(0x50)[0], 300)) <= 10
    assert rig.details == []


def test_calibration_without_turning_changes_nothing() -> None:
    rig = Rig()
    rig.start()
    rig.command(0x71, delay_ns=300 * US)
    rig.wait(5 * SECOND)
    rig.command(0x7E, delay_ns=50 * MS)
    assert [rig.peek(at) for at in range(0x0E, 0x14)] == [0] * 6


def test_calibration_without_a_measurement_changes_nothing() -> None:
    rig = Rig()
    rig.start()
    rig.wait(10 * MS)
    rig.command(0x71, delay_ns=300 * US)
    rig.command(0x7E, delay_ns=50 * MS)
    assert [rig.peek(at) for at in range(0x0E, 0x14)] == [0] * 6
    assert rig.details == []


def test_leaving_a_calibration_that_was_not_entered() -> None:
    rig = Rig()
    rig.start()
    rig.command(0x7E, delay_ns=50 * MS)
    assert rig.details == ["exit calibration: none was entered"]


def test_field_beyond_the_range_is_limited() -> None:
    rig = Rig(iron=(5000.0, 0.0, 0.0))
    rig.start()
    assert rig.words(0x45)[0] == 15_000


def test_two_runs_are_equal() -> None:
    def run() -> list[Any]:
        rig = Rig(lambda t: (7.0 * t % 360.0, 3.0 * np.sin(t), 0.0), clock_error_ppm=300.0)
        rig.start()
        return [rig.words(0x50) for _ in range(50)]

    assert run() == run()
