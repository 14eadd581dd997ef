"""FIFO modes, watermark, overrun, trigger and the 5 µs rule, with a world that numbers its samples."""

from __future__ import annotations

from collections import deque
from struct import unpack
from typing import Any

import numpy as np
import pytest
from adxl345_rig import MS, US, G, Rig, rising
from hypothesis import given, settings
from hypothesis import strategies as some

BYPASS, FIFO, STREAM, TRIGGER = 0x00, 0x40, 0x80, 0xC0
READY, WATERMARK, OVERRUN, SINGLE_TAP = 0x80, 0x02, 0x01, 0x40


def numbered(t: Any) -> dict[str, Any]:
    """x grows by one count in 10 ms, and is 0.1 at the origin."""
    return {"fx": 100.0 * t / 256.0 * G, "fz": G}


class Fifo(Rig):
    """At 100 Hz, samples at 10, 20 … ms after the origin, `number`ed 1, 2 …"""

    def begin(self, fifo_ctl: int, *, enable: int = 0, mapped: int = 0) -> None:
        self.write(0x38, fifo_ctl)
        self.write(0x2F, mapped)
        self.write(0x2E, enable)
        self.origin = self.measure() + 1_100_000

    def after(self, samples: int) -> None:
        """Half a period behind sample number `samples`."""
        self.until(max(self.origin + samples * 10 * MS + 5 * MS, self.time.now))

    def number(self) -> int:
        """Read one sample."""
        return int(unpack("<3h", self.read(0x32, 6))[0])

    def entries(self) -> int:
        return self.byte(0x39) & 0x3F


def test_fifo_mode_fills_and_stops() -> None:
    rig = Fifo(numbered)
    rig.begin(FIFO | 16)
    rig.after(10)
    assert rig.entries() == 10
    rig.after(100)
    assert rig.entries() == 32
    assert [rig.number() for _ in range(33)] == list(range(1, 34))
    assert rig.entries() == 0
    rig.after(103)
    assert [rig.number() for _ in range(3)] == [101, 102, 103]


def test_stream_mode_keeps_the_newest() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 16)
    rig.after(1000)
    assert rig.entries() == 32
    got = [rig.number() for _ in range(33)]
    assert got == list(range(968, 1001))
    assert rig.entries() == 0


def test_as_many_reads_as_entries_empty_it() -> None:
    for mode in (FIFO, STREAM):
        rig = Fifo(numbered)
        rig.begin(mode | 16)
        rig.after(20)
        assert [rig.number() for _ in range(rig.entries())] == list(range(1, 21))
        assert rig.entries() == 0
        assert rig.byte(0x30) & READY == 0


def test_an_empty_fifo_shows_the_last_sample_again() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 16)
    rig.after(2)
    assert [rig.number() for _ in range(4)] == [1, 2, 2, 2]


def test_any_data_register_pops() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 16)
    rig.after(8)
    for register, left in ((0x32, 7), (0x35, 6), (0x37, 5)):
        rig.read(register)
        assert rig.entries() == left
    rig.read(0x31, 7)  # DATA_FORMAT and the data: one pop
    assert rig.entries() == 4
    rig.read(0x36, 4)  # runs on over FIFO_CTL to FIFO_STATUS
    assert rig.entries() == 3
    rig.read(0x38)
    assert rig.entries() == 3


def test_contents_survive_standby() -> None:
    rig = Fifo(numbered)
    rig.begin(FIFO | 16)
    rig.after(12)
    rig.write(0x2D, 0x00)
    rig.wait(500 * MS)
    assert rig.entries() == 12
    assert [rig.number() for _ in range(12)] == list(range(1, 13))


def test_bypass_clears() -> None:
    rig = Fifo(numbered)
    rig.begin(FIFO | 16)
    rig.after(12)
    rig.write(0x38, BYPASS)
    assert rig.entries() == 0
    rig.write(0x38, FIFO | 16)
    assert rig.entries() == 0
    rig.after(14)
    assert [rig.number() for _ in range(rig.entries())] == [13, 14]


def test_watermark_is_live_and_falls_below_the_level() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 5)
    for samples, shown in ((4, 0), (5, WATERMARK), (7, WATERMARK)):
        rig.after(samples)
        assert rig.byte(0x30) & WATERMARK == shown
    rig.byte(0x30)
    for left, shown in ((6, WATERMARK), (5, WATERMARK), (4, 0)):
        rig.number()
        assert (rig.entries(), rig.byte(0x30) & WATERMARK) == (left, shown)


@pytest.mark.parametrize("mode", [BYPASS, FIFO, STREAM, TRIGGER])
def test_samples_zero_is_a_watermark_at_once(mode: int) -> None:
    rig = Rig()
    rig.write(0x38, mode | 8)
    assert rig.byte(0x30) & WATERMARK == 0
    rig.write(0x38, mode)
    assert rig.byte(0x30) & WATERMARK


def test_overrun_in_bypass_mode() -> None:
    rig = Fifo(numbered)
    rig.begin(BYPASS)
    rig.after(1)
    assert rig.byte(0x30) & 0x81 == READY
    rig.after(2)
    assert rig.byte(0x30) & 0x81 == READY | OVERRUN
    rig.read(0x34)
    assert rig.byte(0x30) & 0x81 == 0


@pytest.mark.parametrize("mode", [FIFO, STREAM])
def test_overrun_when_full(mode: int) -> None:
    rig = Fifo(numbered)
    rig.begin(mode | 16)
    rig.after(31)
    assert rig.byte(0x30) & OVERRUN == 0
    rig.after(32)
    assert rig.byte(0x30) & OVERRUN
    rig.number()
    assert rig.byte(0x30) & OVERRUN == 0


def test_sleep_does_not_fill() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 16)
    rig.after(5)
    rig.write(0x2D, 0x0C)
    rig.wait(3000 * MS)
    assert rig.entries() == 5


# -- pins ------------------------------------------------------------------------------------------


def test_watermark_on_int2_inverted() -> None:
    rig = Fifo(numbered, listen="INT2")
    rig.write(0x31, 0x20)
    rig.write(0x38, STREAM | 8)
    rig.write(0x2F, WATERMARK)
    rig.write(0x2E, WATERMARK)
    assert rig.nets["INT2"].level
    origin = rig.measure(data_format=0x2B) + 1_100_000
    rig.until(origin + 85 * MS)
    assert rig.edges["INT2"][-1] == (origin + 80 * MS, False)
    rig.read(0x32, 6)
    assert rig.nets["INT2"].level
    events = rig.time.events_run
    rig.until(origin + 200 * MS)
    assert rig.edges["INT2"][-1] == (origin + 90 * MS, False)
    assert rig.time.events_run - events <= 2


def test_data_ready_and_overrun_on_both_pins() -> None:
    rig = Fifo(numbered, listen="INT1 INT2")
    rig.begin(BYPASS, enable=READY | OVERRUN, mapped=OVERRUN)
    rig.after(3)
    assert rising(rig.edges["INT1"]) == [rig.origin + 10 * MS]
    assert rising(rig.edges["INT2"]) == [rig.origin + 20 * MS]
    rig.read(0x32, 6)
    assert not rig.nets["INT1"].level
    assert not rig.nets["INT2"].level


def test_no_event_without_a_listener() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 8, enable=READY | WATERMARK | OVERRUN)
    rig.after(500)
    assert rig.time.events_run == 0


def test_a_listener_that_comes_late_finds_the_level() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 8, enable=WATERMARK)
    rig.after(20)
    seen: list[tuple[bool, int]] = []
    rig.nets["INT1"].listen(lambda level, when: seen.append((level, when)))
    assert rig.nets["INT1"].level


# -- trigger ---------------------------------------------------------------------------------------


def tapping(t: Any) -> dict[str, Any]:
    """A knock of 5 ms on y at 0.6 s."""
    return {**numbered(t), "fy": 6.0 * G * ((t >= 0.6) & (t < 0.605))}


@pytest.mark.parametrize(("pin_bit", "mapped"), [(0x00, 0x00), (0x20, SINGLE_TAP)])
def test_trigger_keeps_what_was_before_and_goes_on_as_fifo(pin_bit: int, mapped: int) -> None:
    rig = Fifo(tapping)
    rig.write(0x1D, 0x30)
    rig.write(0x21, 0x20)
    rig.write(0x2A, 0x07)
    rig.begin(TRIGGER | pin_bit | 10, enable=SINGLE_TAP, mapped=mapped)
    rig.after(58)
    assert rig.byte(0x39) == 32
    rig.after(62)
    knock_ms = 605 - rig.origin / 1e6
    assert rig.byte(0x39) & 0x80
    last_before = int(knock_ms / 10)
    rig.after(500)
    assert rig.byte(0x39) == 0x80 | 32
    got = [rig.number() for _ in range(33)]
    assert got == list(range(last_before - 9, last_before + 24))


def test_trigger_on_the_other_pin_does_not_count() -> None:
    rig = Fifo(tapping)
    rig.write(0x1D, 0x30)
    rig.write(0x21, 0x20)
    rig.write(0x2A, 0x07)
    rig.begin(TRIGGER | 0x20 | 10, enable=SINGLE_TAP, mapped=0x00)
    rig.after(100)
    assert rig.byte(0x39) == 32
    assert rig.byte(0x30) & SINGLE_TAP


def test_trigger_is_armed_again_by_way_of_bypass() -> None:
    rig = Fifo(tapping)
    rig.write(0x1D, 0x30)
    rig.write(0x21, 0x20)
    rig.write(0x2A, 0x07)
    rig.begin(TRIGGER | 4, enable=SINGLE_TAP)
    rig.after(70)
    rig.byte(0x30)
    rig.write(0x38, STREAM | 4)
    rig.write(0x38, TRIGGER | 4)
    assert rig.byte(0x39) & 0x80
    rig.write(0x38, BYPASS)
    rig.write(0x38, TRIGGER | 4)
    assert rig.byte(0x39) == 0
    rig.after(300)
    assert rig.byte(0x39) == 32


def test_trigger_by_watermark() -> None:
    rig = Fifo(numbered)
    rig.begin(TRIGGER | 6, enable=WATERMARK)
    rig.after(50)
    assert rig.byte(0x39) == 0x80 | 32
    assert rig.number() == 1


# -- the 5 µs rule ---------------------------------------------------------------------------------

BURST = b"\xf2" + bytes(6)


def x_of(miso: bytes) -> int:
    return int(unpack("<h", miso[1:3])[0])


@pytest.mark.parametrize(("clock_hz", "gap_ns", "kept"), [
    (1_600_000, 200, True), (5_000_000, 3_400, True), (5_000_000, 3_300, False), (2_000_000, 900, False),
    (2_000_000, 1_000, True),
])  # fmt: skip
def test_five_microseconds_between_reads(clock_hz: int, gap_ns: int, kept: bool) -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 16)
    rig.after(10)
    duration = 56 * 1_000_000_000 // clock_hz
    now = rig.time.now
    first = rig.chip.transaction(BURST, now, now + duration)
    second = rig.chip.transaction(BURST, now + duration + gap_ns, now + 2 * duration + gap_ns)
    assert (x_of(second) - x_of(first)) == (1 if kept else 0)
    assert bool(rig.chip.reports) is not kept
    rig.until(now + 1 * MS)
    assert rig.number() == (3 if kept else 2)


def test_five_microseconds_to_fifo_status() -> None:
    rig = Fifo(numbered)
    rig.begin(STREAM | 16)
    rig.after(10)
    now = rig.time.now
    rig.chip.transaction(BURST, now, now + 12 * US)
    assert rig.chip.transaction(b"\xb9\x00", now + 13 * US, now + 17 * US)[1] == 10
    assert len(rig.chip.reports) == 1
    assert rig.chip.transaction(b"\xb9\x00", now + 18 * US, now + 22 * US)[1] == 9
    assert len(rig.chip.reports) == 1


def test_running_on_from_the_data_to_fifo_status_is_too_soon_above_1600_khz() -> None:
    for byte_ns, status in ((5 * US, 9), (1_600, 10)):
        rig = Fifo(numbered)
        rig.begin(STREAM | 16)
        rig.after(10)
        now = rig.time.now
        miso = rig.chip.transaction(b"\xf2" + bytes(8), now, now + 9 * byte_ns)
        assert miso[8] == status


def test_no_rule_in_bypass_mode_and_on_i2c() -> None:
    rig = Fifo(numbered)
    rig.begin(BYPASS)
    rig.after(10)
    now = rig.time.now
    for k in range(3):
        rig.chip.transaction(BURST, now + k * 12 * US, now + k * 12 * US + 11_200)
    assert rig.chip.reports == []
    rig.until(now + 1 * MS)
    rig.write(0x38, STREAM)
    rig.after(15)
    got = []
    for _ in range(4):
        rig.chip.i2c.write(b"\x32", rig.time.now)
        rig.wait(25 * US)
        got.append(unpack("<h", rig.chip.i2c.read(6, rig.time.now)[:2])[0])
        rig.wait(200 * US)
    assert np.diff(got).tolist() == [1, 1, 1]
    assert rig.chip.reports == []


def test_reading_at_once_after_the_trigger_is_told() -> None:
    rig = Fifo(tapping)
    rig.write(0x1D, 0x30)
    rig.write(0x21, 0x20)
    rig.write(0x2A, 0x07)
    rig.nets["INT1"].listen(lambda _level, when: times.append(when))
    times: list[int] = []
    rig.begin(TRIGGER | 4, enable=SINGLE_TAP)
    rig.until(650 * MS)
    now = times[0]
    other = Fifo(tapping)
    other.write(0x1D, 0x30)
    other.write(0x21, 0x20)
    other.write(0x2A, 0x07)
    other.begin(TRIGGER | 4, enable=SINGLE_TAP)
    other.until(now + 1 * US)
    other.chip.transaction(BURST, now + 1 * US, now + 12_200)
    assert [report.register for report in other.chip.reports] == ["FIFO"]


# -- against a queue -------------------------------------------------------------------------------


@given(
    some.sampled_from([FIFO, STREAM]),
    some.lists(some.tuples(some.integers(0, 60), some.integers(0, 40)), max_size=12),
)
@settings(max_examples=60, deadline=None)
def test_what_comes_out_is_what_a_queue_gives(mode: int, steps: list[tuple[int, int]]) -> None:
    """Let samples come, read some, again and again."""
    rig = Fifo(numbered)
    rig.begin(mode | 16)
    queue: deque[int] = deque(maxlen=33 if mode == STREAM else None)
    sample = 0
    for coming, reads in steps:
        for _ in range(coming):
            sample += 1
            if mode == STREAM or len(queue) < 33:
                queue.append(sample)
        rig.after(sample)
        assert rig.entries() == min(len(queue), 32)
        for _ in range(min(reads, len(queue))):
            assert rig.number() == queue.popleft()
        assert rig.byte(0x30) & READY == (READY if queue else 0)
