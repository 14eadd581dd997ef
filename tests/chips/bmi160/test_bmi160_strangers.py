"""The access sequences of public drivers, as register traffic: what each does first, waits for and expects.

Facts from the Bosch SensorAPI, the Linux IIO driver, the Zephyr driver and the Arduino (Curie) library.
"""

from __future__ import annotations

from struct import unpack
from typing import Any

import pytest
from bmi160_rig import MS, G, Rig, rising

from boards.chips.registers import ReportKind

US = 1_000


def turning(_t: Any) -> dict[str, float]:
    return {"fz": G, "wx": 1.0, "temperature": 25.0}


def update(rig: Rig, register: int, mask: int, value: int, gap_ns: int) -> None:
    """Read, change some bits, write."""
    rig.write(register, (rig.read(register)[0] & ~mask) | value, gap_ns=gap_ns)


def assert_data(rig: Rig) -> None:
    data = rig.sample()
    assert data[0] == pytest.approx(57.2958 * 16.4, abs=1)
    assert data[5] == 16384


def bosch_init(rig: Rig) -> None:
    """Dummy read and identity with one byte too many, soft reset, 1 ms, dummy read."""
    rig.until(10 * MS)
    rig.read(0x7F, 2)
    assert rig.read(0x00, 2)[0] == 0xD1
    rig.write(0x7E, 0xB6, gap_ns=1 * MS + 1 * MS)
    rig.read(0x7F, 2)


def bosch_normal(rig: Rig, acc_range: int = 0x03) -> None:
    """Both configurations byte by byte in suspend, then power modes with 5 and 81 ms."""
    for register, value in ((0x40, 0x28), (0x41, acc_range), (0x42, 0x28), (0x43, 0x00)):
        rig.write(register, value, gap_ns=1 * MS)
    rig.write(0x7E, 0x11, gap_ns=5 * MS)
    rig.write(0x7E, 0x15, gap_ns=81 * MS)
    assert rig.read(0x02, 2)[0] == 0x00


def test_bosch_start_and_read_with_time() -> None:
    rig = Rig(turning)
    bosch_init(rig)
    bosch_normal(rig)
    rig.wait(20 * MS)
    before = rig.read(0x0C, 16)
    rig.wait(10 * MS)
    after = rig.read(0x0C, 16)
    assert unpack("<6h", after[:12])[5] == 16384
    ticks = [int.from_bytes(data[12:15], "little") for data in (before, after)]
    assert ticks[1] - ticks[0] == pytest.approx(256, abs=2)
    assert rig.chip.reports == []


def test_bosch_data_ready_interrupt() -> None:
    rig = Rig(turning, listen="INT1")
    bosch_init(rig)
    bosch_normal(rig)
    update(rig, 0x51, 0x10, 0x10, 1 * MS)
    update(rig, 0x53, 0x0F, 0x0A, 1 * MS)
    update(rig, 0x54, 0x1F, 0x00, 1 * MS)
    update(rig, 0x56, 0x80, 0x80, 1 * MS)
    rig.edges["INT1"].clear()
    rig.wait(1_000 * MS)
    assert len(rising(rig.edges["INT1"])) in (100, 101)


def test_bosch_fifo_with_time_and_25_bytes_more() -> None:
    rig = Rig(turning)
    bosch_init(rig)
    bosch_normal(rig)
    update(rig, 0x47, 0xFE, 0xD2, 1 * MS)
    rig.write(0x46, 0x20, gap_ns=1 * MS)
    rig.write(0x7E, 0xB0, gap_ns=1 * MS)
    rig.wait(200 * MS)
    count = int.from_bytes(rig.read(0x22, 2), "little") & 0x7FF
    data = rig.read(0x24, count + 25)
    frames, rest = data[:count], data[count:]
    assert [frames[i] for i in range(0, count, 13)] == [0x8C] * 20
    assert rest[0] == 0x44
    assert rest[4:] == b"\x80" * 21


def test_bosch_self_tests() -> None:
    rig = Rig(turning)
    bosch_init(rig)
    bosch_normal(rig, acc_range=0x08)
    rig.write(0x40, 0x2C, gap_ns=1 * MS)
    rig.write(0x6D, 0x0D, gap_ns=50 * MS)
    positive = unpack("<3h", rig.read(0x12, 6))
    rig.write(0x6D, 0x09, gap_ns=50 * MS)
    negative = unpack("<3h", rig.read(0x12, 6))
    assert all(n - p > 8192 for n, p in zip(negative, positive, strict=True))
    update(rig, 0x6D, 0x10, 0x10, 1 * MS)
    rig.wait(20 * MS)
    assert rig.read(0x1B)[0] & 0x02
    rig.write(0x7E, 0xB6, gap_ns=2 * MS)
    rig.read(0x7F, 2)


def test_bosch_foc_polls_every_25_ms_and_stores() -> None:
    rig = Rig(lambda t: {"fx": 0.05 * G, "fz": G, "wx": 0.01})
    bosch_init(rig)
    bosch_normal(rig)
    update(rig, 0x77, 0xC0, 0xC0, 1 * MS)
    rig.write(0x69, 0x7D, gap_ns=1 * MS)
    rig.write(0x7E, 0x03, gap_ns=1 * MS)
    polls = 0
    while not rig.read(0x1B)[0] & 0x08:
        polls += 1
        assert polls < 11
        rig.wait(25 * MS)
    assert rig.read(0x71, 7)[0] == -13 & 0xFF
    update(rig, 0x6A, 0x02, 0x02, 1 * MS)
    rig.write(0x7E, 0xA0, gap_ns=1 * MS)
    if not rig.read(0x1B)[0] & 0x10:
        rig.wait(25 * MS)
    stored = rig.read(0x71, 7)
    rig.write(0x7E, 0xB6, gap_ns=2 * MS)
    rig.read(0x7F, 2)
    assert rig.read(0x71, 7) == stored


def test_linux_probe_begins_with_a_reset_write() -> None:
    """Soft reset written before the chip knows of SPI, 1 ms, dummy read, identity, 3.8 and 80 ms."""
    rig = Rig(turning, listen="INT1")
    rig.until(10 * MS)
    rig.write(0x7E, 0xB6, gap_ns=1 * MS)
    rig.read(0x7F)
    assert rig.read(0x00) == b"\xd1"
    rig.write(0x7E, 0x11, gap_ns=3_800 * US)
    rig.write(0x7E, 0x15, gap_ns=80_000 * US)
    update(rig, 0x53, 0x0F, 0x0B, 2 * US)  # rising edge, active high, output on
    update(rig, 0x54, 0x10, 0x10, 2 * US)
    update(rig, 0x56, 0x80, 0x80, 2 * US)
    update(rig, 0x51, 0x10, 0x10, 2 * US)
    rig.edges["INT1"].clear()
    rig.wait(500 * MS)
    assert len(rising(rig.edges["INT1"])) in (50, 51)
    values = [unpack("<h", rig.read(register, 2))[0] for register in range(0x0C, 0x18, 2)]
    assert values == [pytest.approx(940, abs=1), 0, 0, 0, 0, 16384]
    assert rig.chip.reports == []
    update(rig, 0x40, 0x0F, 0x0A, 0)
    update(rig, 0x41, 0xFF, 0x08, 0)
    assert rig.read(0x40, 2) == b"\x2a\x08"


def test_zephyr_waits_typical_times_and_polls() -> None:
    """Mag, accel, gyro one after the other: 350 µs, 3.2 ms, 55 ms, then polling PMU_STATUS."""
    rig = Rig(turning, listen="INT1")
    rig.until(10 * MS)
    rig.read(0x7F)
    rig.write(0x7E, 0xB6, gap_ns=1 * MS)
    rig.read(0x7F)
    rig.wait(150 * US)
    assert rig.read(0x00) == b"\xd1"
    for command, wait_us, shift, mode in ((0x18, 350, 0, 0), (0x11, 3_200, 4, 1), (0x15, 55_000, 2, 1)):
        rig.write(0x7E, command, gap_ns=wait_us * US)
        for _ in range(10_000):
            if rig.read(0x03)[0] >> shift & 3 == mode:
                break
        assert rig.read(0x03)[0] >> shift & 3 == mode
    assert rig.read(0x02) == b"\x00"
    assert {report.kind for report in rig.chip.reports} <= {ReportKind.TIMING}
    update(rig, 0x40, 0x80, 0x00, 2 * US)
    rig.write(0x55, 0xFF, 0xF0, gap_ns=2 * US)  # a two-byte write
    rig.write(0x53, 0x09, gap_ns=2 * US)  # INT1: edge, active low
    update(rig, 0x51, 0x10, 0x10, 2 * US)
    rig.edges["INT1"].clear()
    while not any(not level for _, level in rig.edges["INT1"]):
        rig.time.run_next()
    status, *interrupts = rig.read(0x1B, 5)
    assert status & 0xC0 == 0xC0
    assert interrupts[1] & 0x10
    assert_data(rig)


def test_arduino_polls_power_modes_with_millisecond_pauses() -> None:
    """Reset, dummy read, both sensors polled, ranges by bits, everything mapped to INT1."""
    rig = Rig(turning)
    rig.until(10 * MS)
    rig.write(0x7E, 0xB6, gap_ns=1 * MS)
    rig.read(0x7F)
    rig.wait(1 * MS)
    for command, shift in ((0x11, 4), (0x15, 2)):
        rig.write(0x7E, command, gap_ns=1 * MS)
        polls = 0
        while rig.read(0x03)[0] >> shift & 3 != 1:
            rig.wait(1 * MS)
            polls += 1
        assert polls == {0x11: 3, 0x15: 79}[command]
        rig.wait(1 * MS)
    update(rig, 0x43, 0x07, 0x03, 1 * MS)
    update(rig, 0x41, 0x0F, 0x03, 1 * MS)
    for register, value in ((0x55, 0xFF), (0x56, 0xF0), (0x57, 0x00)):
        rig.write(register, value, gap_ns=1 * MS)
    rig.wait(20 * MS)
    data = rig.sample()
    assert data[0] == pytest.approx(57.2958 * 131.2, abs=1)
    assert data[5] == 16384
