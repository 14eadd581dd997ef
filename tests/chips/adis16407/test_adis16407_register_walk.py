"""Every register of the fact sheet's map: reset value, access, significant bits, side effects.

The map below is the sheet's own table (section 3), which the tests are generated from.
"""

from __future__ import annotations

import pytest
from adis16407_rig import MS, START_UP, Rig

from boards.chips.registers import ReportKind, UndocumentedAccessError

SHEET = """
| 0x00 | FLASH_CNT | R | 16 | 0x0000 |
| 0x02 | SUPPLY_OUT | R | 12 u | - |
| 0x04, 06, 08 | X, Y, ZGYRO_OUT | R | 14 s | - |
| 0x0A, 0C, 0E | X, Y, ZACCL_OUT | R | 14 s | - |
| 0x10, 12, 14 | X, Y, ZMAGN_OUT | R | 14 s | - |
| 0x16 | BARO_OUT | R | 14 u | - |
| 0x18 | BARO_OUTL | R | 8 u | - |
| 0x1A | TEMP_OUT | R | 12 s | - |
| 0x1C | AUX_ADC | R | 12 u | - |
| 0x1E, 20, 22 | X, Y, ZGYRO_OFF | RW | 13 s | 0x0000 |
| 0x24, 26, 28 | X, Y, ZACCL_OFF | RW | 12 s | 0x0000 |
| 0x2A, 2C, 2E | X, Y, ZMAGN_HIC | RW | 14 s | 0x0000 |
| 0x30, 32, 34 | X, Y, ZMAGN_SIC | RW | 12 u | 0x0800 |
| 0x36 | GPIO_CTRL | RW | 12 | 0x0000 |
| 0x38 | MSC_CTRL | RW | 12 | 0x0006 |
| 0x3A | SMPL_PRD | RW | 8 | 0x0001 |
| 0x3C | SENS_AVG | RW | 11 | 0x0402 |
| 0x3E | SLP_CTRL | RW | 8 | 0x0000 |
| 0x40 | DIAG_STAT | R | 16 | 0x0000 |
| 0x42 | GLOB_CMD | W | 8 | 0x0000 |
| 0x44 | ALM_MAG1 | RW | 16 | 0x0000 |
| 0x46 | ALM_MAG2 | RW | 16 | 0x0000 |
| 0x48 | ALM_SMPL1 | RW | 8 | 0x0000 |
| 0x4A | ALM_SMPL2 | RW | 8 | 0x0000 |
| 0x4C | ALM_CTRL | RW | 16 | 0x0000 |
| 0x4E | AUX_DAC | RW | 12 | 0x0000 |
| 0x52, 54 | LOT_ID1, LOT_ID2 | R | 16 | - |
| 0x56 | PROD_ID | R | 16 | 0x4017 |
| 0x58 | SERIAL_NUM | R | 16 | - |
"""


def _rows() -> list[tuple[int, str, str, str, str]]:
    rows = []
    for line in SHEET.strip().splitlines():
        addresses, names, access, bits, reset = (cell.strip() for cell in line.split("|")[1:6])
        listed = names.split(", ")
        for address, name in zip(addresses.split(", "), listed, strict=True):
            full = name if "_" in name else name + listed[-1][1:]
            rows.append((int(address, 16), full, access, bits, reset))
    return rows


REGISTERS = _rows()
UNUSED = {0x36: 0x00F0, 0x38: 0x0038, 0x3C: 0x00F8, 0x4C: 0x0028}
"""What the field lists (section 5) leave without a meaning within the significant bits."""
ACTING = {0x38: 0x0F00, 0x3A: 0x00FF, 0x3E: 0x00FF}
"""Bits that start something; the walk leaves them alone."""
PLAIN = [row for row in REGISTERS if row[2] == "RW" and row[0] != 0x3E]


def meaning(address: int, bits: str) -> int:
    return ((1 << int(bits.split()[0])) - 1) & ~UNUSED.get(address, 0)


def test_the_walk_knows_every_address() -> None:
    assert [row[0] for row in REGISTERS] == [*range(0x00, 0x50, 2), *range(0x52, 0x5A, 2)]


@pytest.mark.parametrize(("address", "name", "access", "bits", "reset"), REGISTERS)
def test_reset_value_at_both_bytes(address: int, name: str, access: str, bits: str, reset: str) -> None:
    if access == "W" or reset == "-":
        return
    rig = Rig()
    assert rig.read(address) == int(reset, 16), name
    assert rig.read(address + 1) == int(reset, 16), name
    assert rig.chip.reports == []


def test_identity_of_the_unit() -> None:
    rig = Rig(serial_number=0x1234, lot_id=0xCAFEBABE, flash_count=77)
    assert [rig.read(a) for a in (0x00, 0x52, 0x54, 0x58)] == [77, 0xBABE, 0xCAFE, 0x1234]


@pytest.mark.parametrize(("address", "name", "access", "bits", "reset"), PLAIN)
@pytest.mark.parametrize("pattern", [0xFFFF, 0x5555, 0xAAAA])
def test_what_is_written_is_read(
    address: int, name: str, access: str, bits: str, reset: str, pattern: int
) -> None:
    rig = Rig()
    value = pattern & meaning(address, bits) & ~ACTING.get(address, 0)
    if address == 0x3C:
        value = value & 0x00FF | 0x0200  # a range that exists
    if address == 0x4C:
        value &= 0xDDFF  # outputs that exist
    rig.write(address, value)
    assert rig.read(address) == value
    assert rig.chip.reports == []


@pytest.mark.parametrize(("address", "name", "access", "bits", "reset"), PLAIN)
def test_a_write_changes_one_byte_only(address: int, name: str, access: str, bits: str, reset: str) -> None:
    rig = Rig()
    old = rig.read(address)
    low = (old ^ 0x01) & 0xFF
    rig.word(0x8000 | address << 8 | low)
    assert rig.read(address) == old & 0xFF00 | low
    for other, _, _, _, other_reset in PLAIN:
        if other != address:
            assert rig.read(other) == int(other_reset, 16)


@pytest.mark.parametrize(("address", "name", "access", "bits", "reset"), PLAIN)
def test_bits_without_a_meaning_read_zero(
    address: int, name: str, access: str, bits: str, reset: str
) -> None:
    """Of signed numbers the sign may be written there; elsewhere it is reported."""
    unused = ~meaning(address, bits) & 0xFFFF
    if not unused:
        return
    rig = Rig()
    old = rig.read(address)
    rig.write(address, old | unused)
    assert rig.read(address) == old
    kinds = {r.kind for r in rig.chip.reports}
    assert kinds == (set() if bits.endswith("s") else {ReportKind.RESERVED_BITS})


@pytest.mark.parametrize("address", [row[0] for row in REGISTERS if row[2] == "R"])
def test_read_only_registers_ignore_writes(address: int) -> None:
    rig = Rig()
    before = rig.read(address) & 0x3FFF
    rig.write(address, 0xA55A)
    assert rig.read(address) & 0x3FFF == before
    assert {r.kind for r in rig.chip.reports} == {ReportKind.READ_ONLY}


@pytest.mark.parametrize("address", [0x50, *range(0x5A, 0x80, 2)])
def test_addresses_without_a_register(address: int) -> None:
    rig = Rig()
    assert rig.read(address) == 0
    rig.word(0x80FF | address << 8)
    assert {r.kind for r in rig.chip.reports} == {ReportKind.UNDOCUMENTED_ADDRESS}
    with pytest.raises(UndocumentedAccessError):
        Rig(strict=True).read(address)


def test_upper_byte_write_of_the_sheet() -> None:
    """MSC_CTRL self-test, bit 10: DIN 0xB904; the bit clears itself."""
    rig = Rig()
    rig.word(0xB904)
    assert rig.read(0x38) == 0x0406
    rig.wait(100 * MS)
    assert rig.read(0x38) == 0x0006


@pytest.mark.parametrize("way", ["command", "pin", "supply"])
def test_settings_are_lost_at_reset_unless_saved(way: str) -> None:
    rig = Rig()
    rig.chip.pins["RST"].set(True)  # type: ignore[union-attr]
    rig.write(0x1E, 0x0123)
    rig.word(0xC208)
    rig.wait(100 * MS)
    rig.write(0x20, 0x0456)
    if way == "command":
        rig.word(0xC280)
    elif way == "pin":
        rig.nets["RST"].set(False)
        rig.wait(10 * MS)
        assert rig.word(0x5600) == 0xFFFF
        rig.nets["RST"].set(True)
    else:
        rig.chip.power(False)
        assert rig.word(0x5600) == 0xFFFF
        rig.chip.power(True)
    rig.wait(START_UP)
    assert [rig.read(a) for a in (0x1E, 0x20, 0x00, 0x56)] == [0x0123, 0, 1, 0x4017]
    assert rig.chip.reports == []
