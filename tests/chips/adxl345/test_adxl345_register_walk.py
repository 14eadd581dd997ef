"""Every register of the fact sheet's map, on both buses: reset value, access, reserved bits, side effects.

The map below is the sheet's own table (section 2), which the tests are generated from.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from adxl345_rig import MS, Rig

from boards.chips.registers import ReportKind, UndocumentedAccessError

SHEET = """
| 0x00 | DEVID | R | 0xE5 | fixed identity |
| 0x1D | THRESH_TAP | RW | 0x00 | unsigned, 62.5 mg/LSB |
| 0x1E | OFSX | RW | 0x00 | signed 8-bit |
| 0x1F | OFSY | RW | 0x00 | same |
| 0x20 | OFSZ | RW | 0x00 | same |
| 0x21 | DUR | RW | 0x00 | 625 us/LSB |
| 0x22 | LATENT | RW | 0x00 | 1.25 ms/LSB |
| 0x23 | WINDOW | RW | 0x00 | 1.25 ms/LSB |
| 0x24 | THRESH_ACT | RW | 0x00 | unsigned, 62.5 mg/LSB |
| 0x25 | THRESH_INACT | RW | 0x00 | unsigned, 62.5 mg/LSB |
| 0x26 | TIME_INACT | RW | 0x00 | 1 s/LSB |
| 0x27 | ACT_INACT_CTL | RW | 0x00 | |
| 0x28 | THRESH_FF | RW | 0x00 | 62.5 mg/LSB |
| 0x29 | TIME_FF | RW | 0x00 | 5 ms/LSB |
| 0x2A | TAP_AXES | RW | 0x00 | b3 suppress, b2 X, b1 Y, b0 Z enable |
| 0x2B | ACT_TAP_STATUS | R | 0x00 | |
| 0x2C | BW_RATE | RW | 0x0A | b4 LOW_POWER, b3..b0 rate code |
| 0x2D | POWER_CTL | RW | 0x00 | b5 link, b4 AUTO_SLEEP, b3 measure, b2 sleep, b1..b0 wakeup |
| 0x2E | INT_ENABLE | RW | 0x00 | |
| 0x2F | INT_MAP | RW | 0x00 | |
| 0x30 | INT_SOURCE | R | 0x02 | |
| 0x31 | DATA_FORMAT | RW | 0x00 | b4 = 0 |
| 0x32 | DATAX0 | R | 0x00 | X low byte |
| 0x33 | DATAX1 | R | 0x00 | X high byte |
| 0x34 | DATAY0 | R | 0x00 | Y low byte |
| 0x35 | DATAY1 | R | 0x00 | Y high byte |
| 0x36 | DATAZ0 | R | 0x00 | Z low byte |
| 0x37 | DATAZ1 | R | 0x00 | Z high byte |
| 0x38 | FIFO_CTL | RW | 0x00 | |
| 0x39 | FIFO_STATUS | R | 0x00 | |
"""
_ROWS = [[cell.strip() for cell in line.split("|")[1:5]] for line in SHEET.split("\n") if line]
REGISTERS = [(int(address, 16), name, access, int(reset, 16)) for address, name, access, reset in _ROWS]
WRITABLE = [row for row in REGISTERS if row[2] == "RW"]
RESERVED = sorted(set(range(0x40)) - {row[0] for row in REGISTERS})
UNUSED_BITS = {0x2A: 0xF0, 0x2C: 0xE0, 0x2D: 0xC0, 0x31: 0x10}
"""What the field lists leave without a meaning."""
THREE_WIRE = 0x40
"""Would take the data off this bench's wire."""


class Spi:
    """The map through SPI."""

    def __init__(self, **options: bool) -> None:
        self.rig = Rig(**options)

    def read(self, address: int, count: int = 1) -> bytes:
        return self.rig.read(address, count)

    def write(self, address: int, *values: int) -> None:
        self.rig.write(address, *values)


class I2c(Spi):
    """The map through I²C at 400 kHz."""

    def read(self, address: int, count: int = 1) -> bytes:
        face = self.rig.chip.i2c
        self.rig.wait(1 * MS)
        assert face.write(bytes((address,)), self.rig.time.now) == 1
        self.rig.wait(25_000)
        return face.read(count, self.rig.time.now)

    def write(self, address: int, *values: int) -> None:
        self.rig.wait(1 * MS)
        assert self.rig.chip.i2c.write(bytes((address, *values)), self.rig.time.now) == 1 + len(values)


@pytest.fixture(params=[Spi, I2c])
def bus(request: pytest.FixtureRequest) -> Spi:
    maker: Callable[[], Spi] = request.param
    return maker()


@pytest.mark.parametrize(("address", "name", "access", "reset"), REGISTERS)
def test_reset_value(bus: Spi, address: int, name: str, access: str, reset: int) -> None:
    assert bus.read(address) == bytes((reset,)), name
    assert bus.rig.chip.reports == []


def test_reset_values_in_one_burst(bus: Spi) -> None:
    by_address = {address: reset for address, _, _, reset in REGISTERS}
    assert bus.read(0x1D, 29) == bytes(by_address[address] for address in range(0x1D, 0x3A))
    assert bus.rig.chip.reports == []


@pytest.mark.parametrize(("address", "name", "access", "reset"), REGISTERS)
@pytest.mark.parametrize("pattern", [0xFF, 0x55, 0xAA])
def test_access(bus: Spi, address: int, name: str, access: str, reset: int, pattern: int) -> None:
    pattern &= ~UNUSED_BITS.get(address, 0)
    if address == 0x31:
        pattern &= ~THREE_WIRE
    bus.write(address, pattern)
    if access == "RW":
        assert bus.read(address)[0] == pattern
        assert bus.rig.chip.reports == []
    else:
        assert bus.read(address)[0] == reset
        assert [(r.kind, r.register) for r in bus.rig.chip.reports] == [(ReportKind.READ_ONLY, name)]


@pytest.mark.parametrize(("address", "unused"), UNUSED_BITS.items())
def test_bits_without_a_meaning_are_ignored_and_reported(bus: Spi, address: int, unused: int) -> None:
    reset = next(row[3] for row in REGISTERS if row[0] == address)
    bus.write(address, reset | unused)
    assert bus.read(address)[0] == reset
    assert [r.kind for r in bus.rig.chip.reports] == [ReportKind.RESERVED_BITS]


@pytest.mark.parametrize("address", RESERVED)
def test_addresses_without_a_register(bus: Spi, address: int) -> None:
    assert bus.read(address) == b"\x00"
    bus.write(address, 0xFF)
    assert [r.kind for r in bus.rig.chip.reports] == [ReportKind.UNDOCUMENTED_ADDRESS] * 2
    assert bus.read(address) == b"\x00"


def test_a_burst_of_writes_counts_up(bus: Spi) -> None:
    bus.write(0x1D, *range(0x10, 0x1A))
    assert bus.read(0x1D, 10) == bytes(range(0x10, 0x1A))


def test_writes_of_one_register_leave_the_others_alone(bus: Spi) -> None:
    for address, _, _, reset in WRITABLE:
        bus.write(address, (reset ^ 0x05) & ~UNUSED_BITS.get(address, 0))
        for other, _, _, other_reset in WRITABLE:
            if other != address:
                assert bus.read(other)[0] == other_reset
        bus.write(address, reset)


def test_power_off_and_on_restores_every_reset_value(bus: Spi) -> None:
    for address, _, _, reset in WRITABLE:
        bus.write(address, (reset ^ 0x2F) & ~UNUSED_BITS.get(address, 0))
    bus.rig.wait(100 * MS)
    bus.rig.chip.power(False)
    bus.rig.chip.power(True)
    for address, name, _, reset in REGISTERS:
        assert bus.read(address)[0] == reset, name


def test_reading_int_source_clears_latches_only() -> None:
    rig = Rig(lambda t: {"fz": 9.80665, "fx": 30.0 * (t > 0.1)})
    rig.write(0x24, 16)
    rig.write(0x27, 0x70)
    rig.write(0x2E, 0x10)
    rig.measure()
    rig.wait(95 * MS)
    rig.xyz()
    assert rig.byte(0x30) == 0x02
    rig.wait(100 * MS)
    assert rig.byte(0x30) & 0x93 == 0x93  # data ready, activity, watermark, overrun
    rig.write(0x2E, 0x00)
    assert rig.byte(0x30) & 0x93 == 0x83
    rig.xyz()
    assert rig.byte(0x30) == 0x02


def test_report_text() -> None:
    rig = Rig()
    rig.write(0x00, 1)
    rig.write(0x00, 1)
    (report,) = rig.chip.reports
    assert str(report) == "ADXL345 at 0 ns: write to a read-only register: DEVID: write ignored (2 times)"


def test_strict_mode_raises_with_the_report() -> None:
    with pytest.raises(UndocumentedAccessError, match=r"ADXL345 at 0 ns: undocumented address: 0x01: read"):
        Rig(strict=True).read(0x01)
