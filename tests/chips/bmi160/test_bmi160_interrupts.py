"""INT1 and INT2: output stage, mapping, latching, data ready (fact sheet section 3, 0x50 … 0x57)."""

from __future__ import annotations

import pytest
from bmi160_rig import BYTE_NS, MS, Rig, rising

PULSE = 312_500
STATUS_1 = 0x1D
DATA_READY = 0x10


def rig_with(*writes: tuple[int, int], listen: str = "INT1", gyro: bool = False) -> Rig:
    rig = Rig(listen=listen)
    rig.start(gyro=gyro)
    for register, value in writes:
        rig.write(register, value, gap_ns=2_000)
    rig.until(100 * MS - 1)
    for edges in rig.edges.values():
        edges.clear()
    return rig


PUSH_PULL_HIGH = (0x53, 0x0A)
MAPPED = (0x56, 0x80)
ENABLED = (0x51, 0x10)


def test_non_latched_data_ready_is_a_pulse() -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED)
    rig.until(121 * MS)
    assert rig.edges["INT1"] == [
        (100 * MS, True), (100 * MS + PULSE, False),
        (110 * MS, True), (110 * MS + PULSE, False),
        (120 * MS, True), (120 * MS + PULSE, False),
    ]  # fmt: skip


@pytest.mark.parametrize(("register", "count"), [(0x0C, 15), (0x0C, 1), (0x12, 6), (0x17, 1)])
def test_reading_data_ends_the_pulse(register: int, count: int) -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED, gyro=True)
    rig.until(200 * MS - 1)
    rig.edges["INT1"].clear()
    for _ in range(3):
        rig.wait(1 + 20_000)
        rig.read(register, count)
        rig.wait(10 * MS - 1 - 20_000 - (count + 1) * BYTE_NS)
    assert rig.edges["INT1"] == [
        (200 * MS, True), (200 * MS + 20_000, False),
        (210 * MS, True), (210 * MS + 20_000, False),
        (220 * MS, True), (220 * MS + 20_000, False),
    ]  # fmt: skip


def test_reading_something_else_does_not_end_the_pulse() -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED)
    rig.wait(1 + 20_000)
    rig.read(0x00, 4)
    rig.read(0x18, 3)
    assert rig.nets["INT1"].level
    rig.wait(1 * MS)
    assert rig.edges["INT1"] == [(100 * MS, True), (100 * MS + PULSE, False)]


def test_pulses_of_a_reader_that_stops_reading() -> None:
    """The first pulse that nobody reads any more may last until the next sample; edges never get lost."""
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED)
    for _ in range(3):
        rig.wait(1 + 20_000)
        rig.read(0x0C, 15)
        rig.wait(10 * MS - 1 - 20_000 - 16 * BYTE_NS)
    rig.until(200 * MS - 1)
    assert rising(rig.edges["INT1"]) == [n * 10 * MS for n in range(10, 20)]
    assert rig.edges["INT1"][-2:] == [(190 * MS, True), (190 * MS + PULSE, False)]


def test_highest_rate_has_an_edge_for_every_sample() -> None:
    rig = Rig(listen="INT1")
    rig.start(accel=False)
    rig.write(0x42, 0x2D)
    for write in (PUSH_PULL_HIGH, MAPPED, ENABLED):
        rig.write(*write)
    rig.edges["INT1"].clear()
    rig.wait(100 * MS)
    assert len(rising(rig.edges["INT1"])) in (319, 320, 321)


# -- output stage ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("control", "idle", "active"), [(0x08, True, False), (0x0A, False, True), (0x0C, True, False)]
)
def test_level_and_drive(control: int, idle: bool, active: bool) -> None:
    rig = rig_with((0x53, control), MAPPED, ENABLED)
    assert rig.nets["INT1"].level is idle
    rig.until(100 * MS + PULSE // 2)
    assert rig.nets["INT1"].level is active
    rig.until(100 * MS + PULSE)
    assert rig.nets["INT1"].level is idle


@pytest.mark.parametrize("writes", [(MAPPED, ENABLED), (PUSH_PULL_HIGH, ENABLED), (PUSH_PULL_HIGH, MAPPED)])
def test_all_three_of_output_map_and_enable_are_needed(writes: tuple[tuple[int, int], ...]) -> None:
    rig = rig_with(*writes)
    rig.wait(100 * MS)
    assert rig.edges["INT1"] == []


def test_second_pin() -> None:
    rig = rig_with((0x53, 0xA0), (0x56, 0x08), ENABLED, listen="INT1 INT2")
    rig.until(105 * MS)
    assert rig.edges == {"INT1": [], "INT2": [(100 * MS, True), (100 * MS + PULSE, False)]}


def test_both_pins_at_once() -> None:
    rig = rig_with((0x53, 0x8A), (0x56, 0x88), ENABLED, listen="INT1 INT2")
    rig.until(100 * MS + 20_000)
    rig.read(0x0C, 15)
    assert rig.edges == {
        "INT1": [(100 * MS, True), (100 * MS + 20_000, False)],
        "INT2": [(100 * MS, False), (100 * MS + 20_000, True)],
    }


def test_pin_falls_when_the_output_is_switched_off() -> None:
    rig = rig_with((0x53, 0x08), MAPPED, ENABLED)
    assert rig.nets["INT1"].level
    rig.write(0x53, 0x00, gap_ns=2_000)
    assert not rig.nets["INT1"].level


def test_listener_that_comes_later_finds_the_right_level() -> None:
    rig = Rig()
    rig.start(gyro=False)
    for write in ((0x53, 0x08), MAPPED, ENABLED):
        rig.write(*write)
    rig.until(100 * MS + 1_000)
    edges: list[tuple[bool, int]] = []
    rig.nets["INT1"].listen(lambda level, when: edges.append((level, when)))
    assert rig.nets["INT1"].level is False  # active low, in the middle of a pulse
    rig.until(110 * MS)
    assert edges == [(True, 100 * MS + PULSE), (False, 110 * MS)]


def test_pins_are_low_without_power() -> None:
    rig = rig_with((0x53, 0x08), MAPPED, ENABLED)
    rig.chip.power(False)
    assert not rig.nets["INT1"].level
    rig.wait(1_000 * MS)
    assert rig.edges["INT1"][-1][1] is False


def test_soft_reset_silences_the_pin() -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED)
    rig.write(0x7E, 0xB6)
    rig.edges["INT1"].clear()
    rig.wait(1_000 * MS)
    assert rig.edges["INT1"] == []


# -- latching --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("code", range(1, 6))
def test_latch_time_shorter_than_the_sample_period(code: int) -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED, (0x54, code))
    duration = 312_500 << (code - 1)
    rig.wait(1 + 20_000)
    rig.read(0x0C, 15)
    rig.until(119 * MS)
    assert rig.edges["INT1"] == [
        (100 * MS, True), (100 * MS + duration, False),
        (110 * MS, True), (110 * MS + duration, False),
    ]  # fmt: skip


@pytest.mark.parametrize("code", range(6, 15))
def test_latch_time_longer_than_the_sample_period(code: int) -> None:
    """Samples keep the pin up; when they end (suspend), it falls a latch time after its last rise."""
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED, (0x54, code))
    rig.until(109 * MS)
    rig.write(0x7E, 0xB1)
    rig.until(110 * MS + 1_000)
    rig.write(0x7E, 0x10)
    rig.edges["INT1"].clear()
    duration = 312_500 << (code - 1)
    rig.until(110 * MS + duration + 1)
    assert rig.edges["INT1"] == [(110 * MS + duration, False)]


def test_latched_until_the_status_is_read() -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, (0x54, 0x0F), ENABLED)
    assert rig.nets["INT1"].level
    rig.read(0x0C, 15)
    assert rig.nets["INT1"].level
    rig.until(105 * MS)
    assert rig.read(STATUS_1) == bytes((DATA_READY,))
    assert not rig.nets["INT1"].level
    assert rig.read(STATUS_1) == b"\x00"
    rig.until(110 * MS)
    assert rig.nets["INT1"].level
    assert rig.read(0x1C) == b"\x00"  # the other status byte does not clear it
    assert rig.nets["INT1"].level


def test_interrupt_reset_clears_latch_and_status() -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, (0x54, 0x0F), ENABLED)
    rig.until(105 * MS)
    rig.write(0x7E, 0xB1, gap_ns=2_000)
    assert not rig.nets["INT1"].level
    assert rig.read(STATUS_1) == b"\x00"


@pytest.mark.parametrize("code", [0, 1, 2])
def test_status_without_a_listener_is_the_same_as_with_one(code: int) -> None:
    writes = (PUSH_PULL_HIGH, MAPPED, (0x54, code), ENABLED)
    rigs = [rig_with(*writes, listen=listen) for listen in ("INT1", "")]
    for offset in (0, 1_000, 312_499, 312_500, 624_999, 625_000, 3 * MS):
        seen = []
        for rig in rigs:
            rig.until(100 * MS + offset + (code + 1) * 100 * MS)
            seen.append(rig.chip.transaction(bytes((0x80 | STATUS_1, 0)), rig.time.now, rig.time.now + 1)[1])
        expected = DATA_READY if offset < max(1, code) * PULSE else 0
        assert seen == [expected, expected]


# -- data-ready bits of STATUS ------------------------------------------------------------------------------


def test_data_ready_bits_clear_when_the_matching_data_are_read() -> None:
    rig = rig_with(gyro=True)
    rig.until(200 * MS + 1)
    assert rig.read(0x1B) == b"\xc1"
    assert rig.read(0x1B) == b"\xc1"
    rig.read(0x12, 6)
    assert rig.read(0x1B) == b"\x41"
    rig.read(0x0E)
    assert rig.read(0x1B) == b"\x01"
    rig.until(210 * MS)
    assert rig.read(0x1B) == b"\xc1"
    rig.read(0x0C, 15)
    assert rig.read(0x1B) == b"\x01"


def test_data_ready_bits_of_two_rates() -> None:
    rig = rig_with((0x40, 0x26), gyro=True)
    rig.until(400 * MS)
    rig.read(0x0C, 12)
    rig.until(410 * MS)
    assert rig.read(0x1B) == b"\x41"
    rig.until(440 * MS)
    assert rig.read(0x1B) == b"\xc1"


def test_status_after_the_common_burst() -> None:
    """The read ends the pulse and clears what it read, for pin, INT_STATUS and STATUS alike."""
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED, gyro=True)
    rig.until(300 * MS + 10_000)
    assert rig.read(0x1B, 3) == b"\xc1\x00\x10"
    rig.read(0x0C, 15)
    assert rig.read(0x1B, 3) == b"\x01\x00\x00"
    rig.until(310 * MS + 10_000)
    assert rig.read(0x1B, 3) == b"\xc1\x00\x10"


def test_events_end_when_the_listener_leaves() -> None:
    rig = rig_with(PUSH_PULL_HIGH, MAPPED, ENABLED, listen="")
    seen: list[int] = []

    def listener(level: bool, when: int) -> None:
        seen.append(when)

    rig.nets["INT1"].listen(listener)
    rig.wait(100 * MS)
    rig.nets["INT1"].ignore(listener)
    rig.wait(1_000 * MS)
    events, heard = rig.time.events_run, len(seen)
    rig.wait(5_000 * MS)
    assert (rig.time.events_run, len(seen)) == (events, heard)
    rig.nets["INT1"].listen(listener)
    rig.wait(100 * MS)
    assert len(seen) > heard


def test_data_ready_begins_when_the_sensor_is_ready() -> None:
    rig = Rig(listen="INT1")
    rig.start(accel=False, gyro=False)
    for write in (PUSH_PULL_HIGH, MAPPED, ENABLED):
        rig.write(*write)
    rig.spi(b"\x7e\x15")
    normal = rig.time.now + 80 * MS
    rig.wait(200 * MS)
    assert rising(rig.edges["INT1"])[0] == -(-normal // (10 * MS)) * 10 * MS


# -- edge mode ---------------------------------------------------------------------------------------------


def test_edge_mode_gives_a_pulse_while_the_condition_stays() -> None:
    """Watermark of 28 bytes, frames of 7: reached with the fourth frame, and it stays."""
    level = rig_with(PUSH_PULL_HIGH, (0x56, 0x40), (0x46, 7), (0x51, 0x40), (0x47, 0x50))
    edge = rig_with((0x53, 0x0B), (0x56, 0x40), (0x46, 7), (0x51, 0x40), (0x47, 0x50))
    for rig in (level, edge):
        rig.write(0x7E, 0xB0, gap_ns=2_000)
        rig.edges["INT1"].clear()
        rig.until(200 * MS)
    assert level.edges["INT1"] == [(130 * MS, True)]
    assert edge.edges["INT1"] == [(130 * MS, True), (130 * MS + PULSE, False)]
