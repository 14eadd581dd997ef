"""Power modes, their start-up times, and commands that collide (fact sheet sections 2 and 5)."""

from __future__ import annotations

import pytest
from bmi160_rig import BYTE_NS, MS, Rig

from boards.chips.registers import ReportKind

ACCEL, GYRO, MAG = 4, 2, 0


def pmu(rig: Rig, shift: int) -> int:
    return rig.read(0x03)[0] >> shift & 3


def ready() -> Rig:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    return rig


def command(rig: Rig, code: int) -> int:
    """Send a command; returns the time at which its write was complete."""
    rig.spi(bytes((0x7E, code)))
    return rig.time.now


@pytest.mark.parametrize(
    ("before", "code", "shift", "mode", "duration_ns"),
    [
        ((), 0x11, ACCEL, 1, 3_800_000),
        ((), 0x12, ACCEL, 2, 3_800_000),
        ((), 0x15, GYRO, 1, 80 * MS),
        ((), 0x17, GYRO, 3, 80 * MS),
        ((0x17,), 0x15, GYRO, 1, 10 * MS),
        ((), 0x19, MAG, 1, 1 * MS),
        ((), 0x1A, MAG, 2, 1 * MS),
    ],
)
def test_mode_shows_when_its_time_has_passed(
    before: tuple[int, ...], code: int, shift: int, mode: int, duration_ns: int
) -> None:
    rig = ready()
    for earlier in before:
        command(rig, earlier)
        rig.wait(100 * MS)
    old = pmu(rig, shift)
    complete = command(rig, code) + duration_ns
    rig.until(complete - 1)
    assert pmu(rig, shift) == old
    rig.until(max(complete, rig.time.now))
    assert pmu(rig, shift) == mode


@pytest.mark.parametrize(
    ("on", "off", "shift", "mode"),
    [
        (0x11, 0x10, ACCEL, 0),
        (0x15, 0x14, GYRO, 0),
        (0x15, 0x17, GYRO, 3),
        (0x11, 0x12, ACCEL, 2),
        (0x19, 0x18, MAG, 0),
    ],
)
def test_needing_less_is_immediate(on: int, off: int, shift: int, mode: int) -> None:
    rig = ready()
    command(rig, on)
    rig.wait(100 * MS)
    command(rig, off)
    assert pmu(rig, shift) == mode


def test_modes_are_independent() -> None:
    rig = ready()
    for code in (0x11, 0x15, 0x19):
        command(rig, code)
        rig.wait(100 * MS)
    assert rig.read(0x03) == bytes((0b010101,))
    command(rig, 0x14)
    assert rig.read(0x03) == bytes((0b010001,))
    command(rig, 0x12)
    assert rig.read(0x03) == bytes((0b100001,))


def test_second_command_is_dropped_while_one_runs() -> None:
    rig = ready()
    complete = command(rig, 0x15) + 80 * MS
    command(rig, 0x11)
    assert rig.read(0x02) == b"\x40"
    assert [report.kind for report in rig.chip.reports if report.kind is not ReportKind.TIMING] == [
        ReportKind.DROPPED
    ]
    rig.until(complete)
    assert rig.read(0x03) == bytes((0b000100,))
    command(rig, 0x11)
    rig.wait(4 * MS)
    assert rig.read(0x03) == bytes((0b010100,))
    assert rig.read(0x02) == b"\x00"


def test_dropping_a_command_is_no_error_in_strict_mode() -> None:
    rig = Rig(strict=True)
    rig.start(accel=False, gyro=False)
    rig.write(0x7E, 0x15)
    rig.write(0x7E, 0x11)
    assert rig.read(0x02) == b"\x40"


def test_error_flags_clear_when_read() -> None:
    rig = ready()
    command(rig, 0x15)
    command(rig, 0x11)
    assert rig.read(0x02) == b"\x40"
    assert rig.read(0x02) == b"\x00"


def test_next_command_at_the_very_end_is_taken() -> None:
    rig = ready()
    complete = command(rig, 0x11) + 3_800_000
    rig.until(complete)
    command(rig, 0x15)
    rig.wait(80 * MS)
    assert rig.read(0x03) == bytes((0b010100,))
    assert rig.read(0x02) == b"\x00"


def test_soft_reset_is_taken_at_any_time() -> None:
    rig = ready()
    command(rig, 0x15)
    command(rig, 0xB6)
    rig.wait(1 * MS)
    rig.read(0x7F)
    assert rig.read(0x02, 2) == b"\x00\x00"
    rig.wait(100 * MS)
    assert rig.read(0x03) == b"\x00"


def test_command_that_the_sheet_does_not_know_is_reported() -> None:
    rig = ready()
    rig.write(0x7E, 0x42)
    assert [report.kind for report in rig.chip.reports] == [ReportKind.RESERVED_VALUE]
    assert rig.read(0x02, 2) == b"\x00\x00"


def test_repeating_a_mode_is_immediate() -> None:
    rig = ready()
    command(rig, 0x11)
    rig.wait(4 * MS)
    command(rig, 0x11)
    rig.wait(450_000)
    complete = command(rig, 0x15) + 80 * MS
    rig.until(complete)
    assert rig.read(0x03) == bytes((0b010100,))


# -- error codes -------------------------------------------------------------------------------------------


def error(rig: Rig) -> int:
    return rig.read(0x02)[0] >> 1 & 0x0F


@pytest.mark.parametrize(
    ("value", "code"),
    [
        (0x20, 1),
        (0x2D, 1),
        (0x2F, 1),
        (0x38, 1),
        (0x78, 1),
        (0x21, 0),
        (0x2C, 0),
        (0x08, 0),
        (0x18, 0),
        (0xA8, 0),
    ],
)
def test_accelerometer_settings(value: int, code: int) -> None:
    rig = ready()
    rig.write(0x40, value)
    assert error(rig) == code
    assert rig.read(0x40) == bytes((value,))


@pytest.mark.parametrize(
    ("value", "code"), [(0x25, 2), (0x2E, 2), (0x20, 2), (0x38, 2), (0x26, 0), (0x2D, 0), (0x08, 0)]
)
def test_gyroscope_settings(value: int, code: int) -> None:
    rig = ready()
    rig.write(0x42, value)
    assert error(rig) == code


def test_averaging_longer_than_the_output_period_is_invalid() -> None:
    """128 samples of 1600 Hz last 80 ms: possible at 12.5 Hz, not at 25 Hz."""
    rig = ready()
    rig.write(0x40, 0xF5)
    assert error(rig) == 0
    rig.write(0x40, 0xF6)
    assert error(rig) == 1


def test_invalid_rate_leaves_the_sensor_at_the_old_one() -> None:
    rig = Rig(motion=lambda t: {"wx": t})
    rig.start()
    rig.write(0x42, 0x20)
    seen = set()
    for _ in range(100):
        seen.add(rig.sample()[0])
        rig.wait(10 * MS - 13 * BYTE_NS)
    assert 99 <= len(seen) <= 100


def test_first_error_stays_until_read() -> None:
    rig = ready()
    rig.write(0x42, 0x20)
    rig.write(0x40, 0x20)
    assert error(rig) == 2


def test_low_power_with_unfiltered_data() -> None:
    rig = ready()
    rig.write(0x45, 0x08)  # accelerometer FIFO data unfiltered
    rig.write(0x47, 0x50)
    assert error(rig) == 0
    rig.write(0x7E, 0x12, gap_ns=4 * MS)
    assert error(rig) == 7
    rig.write(0x45, 0x88)
    rig.write(0x50, 0x07)
    rig.write(0x59, 0x80)
    assert error(rig) == 3


def test_headerless_with_two_rates() -> None:
    rig = ready()
    rig.start()
    rig.write(0x47, 0xC0)
    assert error(rig) == 0
    rig.write(0x42, 0x29)
    assert error(rig) == 6
    assert rig.read(0x22, 2) == b"\x00\x00"
