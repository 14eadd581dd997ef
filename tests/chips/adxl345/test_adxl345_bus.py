"""Frames on SPI and I²C, supply, and what breaks the rules of the wires."""

from __future__ import annotations

import pytest
from adxl345_rig import MS, SECOND, US, G, Rig

from boards.chips.adxl345 import Adxl345
from boards.chips.registers import ReportKind, UndocumentedAccessError
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.virtual_time import VirtualTime
from hal.errors import BusError, ErrorKind


def details(rig: Rig) -> list[str]:
    return [report.detail for report in rig.chip.reports]


# -- SPI -------------------------------------------------------------------------------------------


def test_constants_of_the_sheet() -> None:
    rig = Rig(lambda t: {"fx": 0.5 * G, "fy": -0.25 * G, "fz": G})
    assert rig.spi(bytes.fromhex("8000")) == bytes.fromhex("00e5")
    rig.spi(bytes.fromhex("310b"))
    rig.spi(bytes.fromhex("2d08"))
    rig.wait(20 * MS)
    assert rig.spi(bytes.fromhex("f2000000000000")) == bytes.fromhex("008000c0ff0001")


def test_nothing_is_driven_that_matters_during_a_write() -> None:
    assert Rig().spi(bytes.fromhex("2d08")) == bytes(2)


def test_multi_byte_write_and_read() -> None:
    rig = Rig()
    rig.spi(bytes((0x40 | 0x1E, 1, 2, 3)))
    assert rig.spi(bytes((0xC0 | 0x1E, 0, 0, 0)))[1:] == b"\x01\x02\x03"
    assert rig.chip.reports == []


def test_without_the_multi_byte_bit_the_address_stays() -> None:
    rig = Rig()
    rig.spi(bytes((0x1E, 1, 2, 3)))
    assert rig.spi(bytes((0xC0 | 0x1E, 0, 0)))[1:] == b"\x03\x00"
    assert rig.spi(bytes((0x80, 0, 0, 0)))[1:] == b"\xe5\xe5\xe5"
    assert details(rig) == ["several bytes without the multi-byte bit; the address stays"]
    assert rig.chip.reports[0].kind is ReportKind.PROTOCOL
    assert rig.chip.reports[0].count == 2


def test_the_address_wraps_within_six_bits() -> None:
    rig = Rig()
    assert rig.read(0x3F, 2) == b"\x00\xe5"


@pytest.mark.parametrize("command", [0x80, 0xF2, 0x2D, 0x6D])
def test_an_address_without_data_does_nothing(command: int) -> None:
    rig = Rig()
    assert rig.spi(bytes((command,))) == b"\x00"
    assert rig.byte(0x2D) == 0
    assert details(rig) == ["transfer of an address without data"]


def test_an_empty_transfer_is_nothing() -> None:
    rig = Rig()
    assert rig.chip.transaction(b"", 0, 0) == b""
    assert rig.chip.reports == []


def test_three_wire_mode_on_four_wires_and_back() -> None:
    rig = Rig()
    rig.write(0x31, 0x40)
    assert rig.byte(0x00) == 0xFF
    rig.write(0x31, 0x00)
    assert rig.byte(0x00) == 0xE5


def test_three_wire_board() -> None:
    rig = Rig(spi_wires=3)
    assert rig.byte(0x00) == 0xFF
    rig.write(0x31, 0x40)
    assert rig.byte(0x00) == 0xE5


@pytest.mark.parametrize(("duration_ns", "reported"), [(3_200, False), (3_199, False), (3_040, True)])
def test_clock_limit(duration_ns: int, reported: bool) -> None:
    """Two bytes at 5 MHz, the same rounded down, and at 5.26 MHz."""
    rig = Rig()
    assert rig.chip.transaction(b"\x80\x00", 0, duration_ns) == b"\x00\xe5"
    expected = ["clock faster than 5 MHz: undefined, served as if it were slower"]
    assert details(rig) == (expected if reported else [])


def test_pause_between_two_transfers() -> None:
    rig = Rig()
    rig.chip.transaction(b"\x80\x00", 0, 4_000)
    rig.chip.transaction(b"\x80\x00", 4_150, 8_150)
    assert details(rig) == []
    assert rig.chip.transaction(b"\x80\x00", 8_250, 12_250) == b"\x00\xe5"
    assert details(rig) == ["chip select high for less than 150 ns"]


def test_pause_after_the_common_read() -> None:
    rig = Rig()
    rig.measure()
    rig.wait(30 * MS)
    burst = b"\xf2" + bytes(6)
    now = rig.time.now
    for start in (now, now + 20 * US, now + 40 * US):
        rig.chip.transaction(burst, start, start + 14 * US)
    assert details(rig) == []
    rig.chip.transaction(burst, now + 54 * US + 100, now + 68 * US + 100)
    assert details(rig) == ["chip select high for less than 150 ns"]


def test_too_fast_a_common_read_is_told_every_time() -> None:
    rig = Rig(byte_ns=1_000)
    rig.measure()
    rig.wait(30 * MS)
    before = rig.chip.reports[0].count
    for _ in range(3):
        rig.wait(1 * MS)
        assert rig.xyz() == (0, 0, 256)
    assert rig.chip.reports[0].count == before + 3


@pytest.mark.parametrize(
    ("rate", "clock_hz", "reported"),
    [
        (0xF, 2_000_000, False),
        (0xF, 1_600_000, True),
        (0xE, 1_000_000, True),
        (0xD, 400_000, False),
        (0xD, 200_000, True),
        (0xB, 100_000, False),
        (0xB, 50_000, True),
        (0x8, 20_000, False),
    ],
)
def test_clock_that_the_output_rate_wants(rate: int, clock_hz: int, reported: bool) -> None:
    rig = Rig()
    rig.measure(rate)
    rig.byte_ns = 8 * SECOND // clock_hz
    rig.xyz()
    expected = ["clock too slow for the output rate: samples are lost or noisier"]
    assert details(rig) == (expected if reported else [])


def test_mode() -> None:
    assert Adxl345.spi_modes == (3,)


# -- I²C -------------------------------------------------------------------------------------------


class Bus:
    """A processor with the chip on its I²C bus."""

    def __init__(self, frequency_hz: int = 400_000, **options: bool) -> None:
        self.rig = Rig(**options)
        self.cpu = EmulatedCpu(self.rig.time, "mcu", 100_000_000)
        self.bus = EmulatedI2cBus(self.cpu, frequency_hz)
        self.bus.attach(self.rig.chip.i2c.address, self.rig.chip.i2c)


@pytest.mark.parametrize(("high", "address"), [(False, 0x53), (True, 0x1D)])
def test_address_pin(high: bool, address: int) -> None:
    bench = Bus(sdo_high=high)
    assert bench.bus.transaction(address, b"\x00", 1) == b"\xe5"
    with pytest.raises(BusError) as caught:
        bench.bus.transaction(address ^ 0x4E, b"\x00", 1)
    assert caught.value.kind is ErrorKind.ADDRESS_NACK
    assert bench.rig.chip.reports == []


def test_pointer_counts_up_and_stays_over_a_stop() -> None:
    bus = Bus().bus
    bus.transaction(0x53, bytes((0x1D, 1, 2, 3, 4)))
    assert bus.transaction(0x53, b"\x1d", 2) == b"\x01\x02"
    assert bus.transaction(0x53, b"", 2) == b"\x03\x04"
    bus.transaction(0x53, b"\x1e")
    assert bus.transaction(0x53, b"", 1) == b"\x02"


def test_pointer_wraps_within_six_bits() -> None:
    assert Bus().bus.transaction(0x53, b"\x3f", 2) == b"\x00\xe5"


def test_more_than_six_bits_of_address_are_told() -> None:
    bench = Bus()
    assert bench.bus.transaction(0x53, b"\x80", 1) == b"\xe5"
    assert bench.rig.chip.reports[0].kind is ReportKind.PROTOCOL


def test_presence_check() -> None:
    assert Bus().bus.transaction(0x53) == b""


@pytest.mark.parametrize(
    ("frequency_hz", "reported"), [(100_000, False), (400_000, False), (1_000_000, True)]
)
def test_i2c_clock_limit(frequency_hz: int, reported: bool) -> None:
    bench = Bus(frequency_hz)
    for _ in range(3):
        assert bench.bus.transaction(0x53, b"\x00", 1) == b"\xe5"
        bench.bus.transaction(0x53, b"\x1d\x01\x02\x03")
    assert bool(bench.rig.chip.reports) is reported


@pytest.mark.parametrize(("rate", "reported"), [(0xD, False), (0xE, True), (0xF, True)])
def test_rates_that_are_not_for_i2c(rate: int, reported: bool) -> None:
    bench = Bus()
    for register, value in ((0x2C, rate), (0x2D, 0x08)):
        bench.bus.transaction(0x53, bytes((register, value)))
    bench.bus.transaction(0x53, b"\x32", 6)
    assert details(bench.rig) == (["output rate of 1600 Hz or more: not for this bus"] if reported else [])


# -- supply ----------------------------------------------------------------------------------------


def test_without_supply_nothing_answers() -> None:
    bench = Bus()
    bench.rig.chip.power(False)
    assert bench.rig.spi(b"\x80\x00") == b"\xff\xff"
    with pytest.raises(BusError) as caught:
        bench.bus.transaction(0x53, b"\x00", 1)
    assert caught.value.kind is ErrorKind.ADDRESS_NACK
    assert bench.rig.chip.reports == []


def test_brownout_ends_measurement() -> None:
    rig = Rig(listen="INT1")
    rig.write(0x2E, 0x80)
    rig.measure()
    rig.wait(50 * MS)
    assert rig.nets["INT1"].level
    rig.chip.brownout()
    assert not rig.nets["INT1"].level
    assert (rig.byte(0x2D), rig.byte(0x2C), rig.xyz()) == (0x00, 0x0A, (0, 0, 0))
    events = rig.time.events_run
    rig.wait(1 * SECOND)
    assert rig.time.events_run == events


def test_parameters_are_checked() -> None:
    for options, word in (({"spi_wires": 2}, "spi_wires"), ({"supply_v": 5.0}, "supply_v")):
        with pytest.raises(ValueError, match=word):
            Adxl345(VirtualTime(), Rig().world, **options)  # type: ignore[arg-type]


def test_strict_mode_raises_for_broken_timing() -> None:
    with pytest.raises(UndocumentedAccessError, match="5 MHz"):
        Rig(strict=True).chip.transaction(b"\x80\x00", 0, 2_000)
