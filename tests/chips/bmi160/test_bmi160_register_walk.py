"""Every register of the fact sheet's table: reset value and access, written down here once more."""

from __future__ import annotations

import pytest
from bmi160_rig import MS, Rig

from boards.chips.registers import ReportKind, UndocumentedAccessError

# address, access, reset value: fact sheet section 3 (ranges spelled out).
TABLE = """
00 R D1   02 R 00   03 R 00
04 R 00   05 R 00   06 R 00   07 R 00   08 R 00   09 R 00   0A R 00   0B R 00
0C R 00   0D R 00   0E R 00   0F R 00   10 R 00   11 R 00
12 R 00   13 R 00   14 R 00   15 R 00   16 R 00   17 R 00
1B R 01   1C R 00   1D R 00   1E R 00   1F R 00   20 R 00   21 R 00   22 R 00   23 R 00
40 RW 28  41 RW 03  42 RW 28  43 RW 00  44 RW 0B  45 RW 88  46 RW 80  47 RW 10
4B RW 20  4C RW 80  4D RW 42  4E RW 4C  4F RW 00
50 RW 00  51 RW 00  52 RW 00  53 RW 00  54 RW 00  55 RW 00  56 RW 00  57 RW 00  58 RW 00  59 RW 00
5A RW 07  5B RW 30  5C RW 81  5D RW 0B  5E RW C0
5F RW 00  60 RW 14  61 RW 14  62 RW 24  63 RW 04  64 RW 0A
65 RW 18  66 RW 48  67 RW 08  68 RW 11
69 RW 00  6A RW 00  6B RW 00  6C RW 00  6D RW 00
70 RW 00  71 RW 00  72 RW 00  73 RW 00  74 RW 00  75 RW 00  76 RW 00  77 RW 00
78 R 00   79 R 00   7A RW 15  7B RW 03
"""
_CELLS = TABLE.split()
REGISTERS = [(int(_CELLS[i], 16), _CELLS[i + 1], int(_CELLS[i + 2], 16)) for i in range(0, len(_CELLS), 3)]
SENSOR_TIME = {0x18, 0x19, 0x1A}
SPECIAL = {0x24, 0x7E, 0x7F} | SENSOR_TIME
RESERVED = sorted(set(range(0x80)) - {address for address, _, _ in REGISTERS} - SPECIAL)

# Bits that the table's field lists leave without a meaning.
UNUSED_BITS = {
    0x41: 0xF0, 0x42: 0xC0, 0x43: 0xF8, 0x44: 0xF0, 0x47: 0x01, 0x4B: 0x01, 0x4C: 0x40, 0x50: 0x08,
    0x51: 0x80, 0x52: 0xF0, 0x54: 0xC0, 0x58: 0x77, 0x59: 0x7F, 0x5C: 0x38, 0x62: 0xC0, 0x63: 0x38,
    0x64: 0xE0, 0x67: 0xC0, 0x68: 0xC8, 0x69: 0x80, 0x6A: 0xFD, 0x6B: 0xCE, 0x6C: 0x80, 0x6D: 0xE0,
    0x70: 0xF0, 0x7B: 0xF0,
}  # fmt: skip


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    return rig


@pytest.mark.parametrize(("address", "access", "reset"), REGISTERS)
def test_reset_value_after_power_up(rig: Rig, address: int, access: str, reset: int) -> None:
    assert rig.read(address) == bytes((reset,))
    assert rig.chip.reports == []


def test_reset_values_in_one_burst(rig: Rig) -> None:
    data = rig.read(0x40, 0x3C)
    assert {0x40 + i: data[i] for i in range(0x3C)} == {
        address: next((reset for a, _, reset in REGISTERS if a == address), 0)
        for address in range(0x40, 0x7C)
    }


@pytest.mark.parametrize(("address", "access", "reset"), REGISTERS)
def test_access_kind(rig: Rig, address: int, access: str, reset: int) -> None:
    pattern = (reset ^ 0xFF) & ~UNUSED_BITS.get(address, 0)
    if address == 0x6B:
        pattern &= ~0x01  # 3-wire mode would take the data off this bench's wire
    rig.write(address, pattern)
    if access == "RW":
        assert rig.read(address)[0] == pattern
        assert not any(r.kind is ReportKind.READ_ONLY for r in rig.chip.reports)
    else:
        assert rig.read(address)[0] == reset
        assert [r.kind for r in rig.chip.reports] == [ReportKind.READ_ONLY]


@pytest.mark.parametrize(("address", "unused"), UNUSED_BITS.items())
def test_bits_without_a_meaning_are_ignored_and_reported(rig: Rig, address: int, unused: int) -> None:
    reset = next(reset for a, _, reset in REGISTERS if a == address)
    rig.write(address, reset | unused)
    assert rig.read(address)[0] == reset
    assert ReportKind.RESERVED_BITS in {report.kind for report in rig.chip.reports}


@pytest.mark.parametrize("address", RESERVED)
def test_addresses_without_a_register(rig: Rig, address: int) -> None:
    assert rig.read(address) == b"\x00"
    rig.write(address, 0xFF)
    assert [r.kind for r in rig.chip.reports] == [ReportKind.UNDOCUMENTED_ADDRESS] * 2
    assert rig.read(address) == b"\x00"


def test_burst_that_runs_on_into_unused_addresses_is_no_report(rig: Rig) -> None:
    assert rig.read(0x00, 4) == b"\xd1\x00\x00\x00"
    assert rig.read(0x5A, 0x26)[-4:] == b"\x00\x00\x00\x00"
    assert [r.kind for r in rig.chip.reports] == [ReportKind.WRITE_ONLY]  # CMD


def test_command_register_is_write_only(rig: Rig) -> None:
    assert rig.read(0x7E) == b"\x00"
    assert [r.kind for r in rig.chip.reports] == [ReportKind.WRITE_ONLY]
    rig.write(0x7E, 0x11)
    assert rig.read(0x7E) == b"\x11"


def test_dummy_register_reads_as_zero_without_a_report(rig: Rig) -> None:
    assert rig.read(0x7F) == b"\x00"
    assert rig.chip.reports == []


@pytest.mark.parametrize(
    ("register", "value", "what"),
    [
        (0x50, 0x80, "flat"),
        (0x50, 0x40, "orientation"),
        (0x50, 0x20, "tap"),
        (0x50, 0x10, "tap"),
        (0x52, 0x08, "step"),
        (0x7B, 0x0B, "step"),
        (0x62, 0x26, "significant motion"),
        (0x58, 0x80, "unfiltered"),
        (0x59, 0x80, "unfiltered"),
        (0x6C, 0x01, "PMU trigger"),
        (0x6B, 0x10, "secondary interface"),
        (0x4D, 0x42, "secondary interface"),
        (0x47, 0x30, "secondary interface"),
        (0x70, 0x04, "watchdog"),
        (0x7E, 0x19, "secondary interface"),
    ],
)
def test_what_is_not_modelled_is_reported_when_touched(register: int, value: int, what: str) -> None:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    heard = []
    rig.chip.log.listeners.append(heard.append)
    rig.write(register, value)
    assert [report.kind for report in heard] == [ReportKind.NOT_MODELLED]
    assert what in heard[0].detail

    strict = Rig(strict=True)
    strict.start(accel=False, gyro=False)
    with pytest.raises(UndocumentedAccessError, match=what):
        strict.write(register, value)


def test_report_text_and_counting(rig: Rig) -> None:
    rig.write(0x00, 1)
    rig.until(20 * MS)
    rig.write(0x00, 1)
    (report,) = rig.chip.reports
    assert str(report) == (
        "BMI160 at 10003200 ns: write to a read-only register: CHIP_ID: write ignored (2 times)"
    )
    assert report.count == 2


def test_strict_mode_raises_with_the_report() -> None:
    rig = Rig(strict=True)
    rig.start(accel=False, gyro=False)
    with pytest.raises(
        UndocumentedAccessError, match=r"BMI160 at 10003200 ns: undocumented address: 0x01: read"
    ):
        rig.read(0x01)


def test_soft_reset_loads_every_reset_value_again(rig: Rig) -> None:
    rig.write(0x7E, 0x11, gap_ns=4 * MS)
    for address, access, reset in REGISTERS:
        if access == "RW" and address != 0x4D:
            rig.write(address, (reset ^ 0x55) & ~UNUSED_BITS.get(address, 0))
    rig.wait(100 * MS)
    rig.write(0x7E, 0xB6, gap_ns=1 * MS)
    rig.read(0x7F)
    for address, _, reset in REGISTERS:
        assert rig.read(address)[0] == reset, f"0x{address:02X}"
