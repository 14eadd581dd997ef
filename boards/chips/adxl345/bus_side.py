"""Supply, bus interfaces and their rules (fact sheet sections 1 and 5).

SPI: first byte bit 7 = read, bit 6 = multi-byte, bits 5 … 0 the register, which then counts up if bit 6 is
set. What breaks a rule is served as if it had not, and reported.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Final

from boards.chips.adxl345.core import Core
from boards.chips.adxl345.fifo import BYPASS, POP_NS
from boards.chips.adxl345.fifo_lane import FifoLane
from boards.chips.adxl345.i2c_face import I2cFace
from boards.chips.adxl345.pin_net import PinNet
from boards.chips.adxl345.register_map import (
    ACT_TAP_STATUS,
    BW_RATE,
    DATA,
    DATA_FORMAT,
    DATAX0,
    DATAZ1,
    FIFO_STATUS,
    INT_SOURCE,
    THREE_WIRE,
)
from boards.chips.adxl345.settings import TICK_RATE_HZ, rate_period
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.world import ImuWorld
from hal.emulated.spi import SpiChip
from hal.emulated.virtual_time import VirtualTime

FASTEST_BYTE_NS: Final = 1_600
"""8 bits at 5 MHz."""
CS_HIGH_NS: Final = 150
"""Chip select between two transfers."""

_READ: Final = 0x80
_MULTI: Final = 0x40
_ADDRESS: Final = 0x3F
_UNDRIVEN: Final = 0xFF
"""What a wire shows that the chip does not drive."""

_LOWEST_SPI_HZ_AT_FASTEST: Final = 2_000_000
_SPI_HZ_PER_RATE_HZ: Final = 500
_FASTEST_PERIOD_ON_I2C: Final = 4
"""Ticks: 800 Hz."""
_CLOCK_MARGIN: Final = 0.9
"""A byte's share of the transfer also holds set-up, hold and stalls."""


class BusSide(SpiChip):
    """The part of the chip that a bus and a supply see; pins and events are `Adxl345`'s."""

    feels: ClassVar[str] = "imu"
    """The world that it asks."""
    measures: ClassVar[tuple[str, ...]] = ("accel",)
    """Of what the world tells."""
    spi_modes: ClassVar[tuple[int, ...]] = (3,)
    """Clock modes (fact sheet section 1)."""

    __slots__ = (
        "_core",
        "_ended_ns",
        "_lane",
        "_read_ns",
        "_ready_ns",
        "_three_wire",
        "_time",
        "_vetted",
        "i2c",
        "log",
        "name",
        "pins",
        "powered",
    )

    def __init__(
        self,
        time: VirtualTime,
        world: ImuWorld,
        *,
        clock_error_ppm: float,
        supply_v: float,
        sdo_high: bool,
        spi_wires: int,
        strict: bool,
        name: str,
    ) -> None:
        if spi_wires not in (3, 4):
            raise ValueError(f"{name}: spi_wires = {spi_wires}; the part has 3-wire and 4-wire SPI, e.g. 4")
        if not 2.0 <= supply_v <= 3.6:
            raise ValueError(f"{name}: supply_v = {supply_v}; the part takes 2.0 to 3.6 V, e.g. 2.5")
        self.name = name
        self.log = AccessLog(name, strict=strict)
        self.pins: dict[str, PinNet | None] = {"INT1": None, "INT2": None}
        self.i2c = I2cFace(self, 0x1D if sdo_high else 0x53)
        self._time = time
        self._three_wire = spi_wires == 3
        self._core = Core(world, self.log, round(clock_error_ppm * 1000.0), supply_v)
        self._lane = FifoLane(self._core)
        self.powered = True
        """Whether the chip has its supply."""
        self._read_ns: int | None = None
        """When the short way last read the data registers, while the core does not know of it."""
        self._ended_ns = self._ready_ns = 0
        """End of the last SPI transfer, and from when on the next may come."""
        self._vetted = -1
        """How long (ns) a read of the six data bytes takes that keeps all rules at the present set-up; -1:
        none has done so."""

    @property
    def reports(self) -> list[AccessReport]:
        """Accesses outside the documents or the model, the first of each kind with its time."""
        return self.log.reports

    # -- power -------------------------------------------------------------------------------------

    def power(self, on: bool) -> None:
        """Switch the supply, now. Without power the chip does not answer; with it, it starts in standby."""
        if on == self.powered:
            return
        self.powered = on
        self._read_ns = None
        self._lane.drop()
        self._vetted = -1
        if on:
            self._core.restart()
        self._after_change(self._time.now)

    def brownout(self) -> None:
        """A dip of the supply, now: registers are lost and the chip starts from standby."""
        self.power(False)
        self.power(True)

    # -- SPI -----------------------------------------------------------------------------------------

    def _transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        count = len(mosi) - 1
        if not self.powered or count < 0:
            return bytes((_UNDRIVEN,)) * len(mosi)
        fits = self._keeps_wire_rules(count + 1, start_ns, end_ns)
        self._ended_ns, self._ready_ns = end_ns, end_ns + CS_HIGH_NS
        command = mosi[0]
        address = command & _ADDRESS
        if count == 0:
            self._report_protocol("transfer of an address without data", start_ns)
            return b"\x00"
        if count > 1 and not command & _MULTI:
            self._report_protocol("several bytes without the multi-byte bit; the address stays", start_ns)
        if command & _READ:
            byte_ns = (end_ns - start_ns) // (count + 1)
            if address in DATA:
                fits = self._fast_enough(byte_ns, start_ns) and fits
            drives = self._drives_data()
            data = self._read(address, count, start_ns, byte_ns, 1 if command & _MULTI else 0)
            if fits and drives and count == 6 and address == DATAX0:
                self._vetted = end_ns - start_ns
            self._after_read(address, count, start_ns)
            return b"\x00" + (data if drives else bytes((_UNDRIVEN,)) * count)
        self._write(address, mosi[1:], start_ns, end_ns, 1 if command & _MULTI else 0)
        return bytes(count + 1)

    def _keeps_wire_rules(self, length: int, start_ns: int, end_ns: int) -> bool:
        """Clock and pause. A transfer without duration and one that follows at once have no time of their
        own: whoever drives the chip so does not model it."""
        keeps = True
        if 0 < end_ns - start_ns < length * FASTEST_BYTE_NS - 1:
            detail = "clock faster than 5 MHz: undefined, served as if it were slower"
            self.log.report(ReportKind.TIMING, "SPI", detail, start_ns)
            keeps = False
        if self._ended_ns < start_ns < self._ready_ns:
            detail = f"chip select high for less than {CS_HIGH_NS} ns"
            self.log.report(ReportKind.TIMING, "SPI", detail, start_ns)
            keeps = False
        return keeps

    def _fast_enough(self, byte_ns: int, time_ns: int) -> bool:
        """Whether the bus is as fast as the output rate wants it."""
        period = rate_period(self._core.registers.values[BW_RATE])
        wanted_hz = _LOWEST_SPI_HZ_AT_FASTEST if period <= 2 else _SPI_HZ_PER_RATE_HZ * TICK_RATE_HZ / period
        if byte_ns * wanted_hz * _CLOCK_MARGIN <= 8e9:
            return True
        detail = "clock too slow for the output rate: samples are lost or noisier"
        self.log.report(ReportKind.TIMING, "SPI", detail, time_ns)
        return False

    def _drives_data(self) -> bool:
        """Whether the chip sends on the wire that the board reads from."""
        return bool(self._core.registers.values[DATA_FORMAT] & THREE_WIRE) == self._three_wire

    # -- I²C -----------------------------------------------------------------------------------------

    def i2c_read(self, address: int, count: int, time_ns: int) -> bytes:
        """A burst read; see `I2cFace`."""
        if address in DATA and self._too_fast_for_i2c:
            detail = "output rate of 1600 Hz or more: not for this bus"
            self.log.report(ReportKind.TIMING, "I2C", detail, time_ns)
        data = self._read(address, count, time_ns, None, 1)
        self._after_read(address, count, time_ns)
        return data

    @property
    def _too_fast_for_i2c(self) -> bool:
        return rate_period(self._core.registers.values[BW_RATE]) < _FASTEST_PERIOD_ON_I2C

    def i2c_write(self, address: int, data: bytes, time_ns: int) -> None:
        """A burst write."""
        self._write(address, data, time_ns, time_ns, 1)

    # -- registers -----------------------------------------------------------------------------------

    def _read(self, first: int, count: int, start_ns: int, byte_ns: int | None, step: int) -> bytes:
        """`count` registers from `first` on, as of `start_ns`. `byte_ns`: of SPI, where reading data
        takes its time; None where that never matters."""
        core = self._core
        if _is_still(first, count if step else 1):
            registers = core.registers
            return bytes(
                [
                    registers.read(first + step * i & _ADDRESS, start_ns, running_on=i > 0)
                    for i in range(count)
                ]
            )
        self._settle_short_way()
        core.advance(start_ns)
        if first == DATAX0 and count == len(DATA) and step:
            return self._read_sample(start_ns, byte_ns)
        data = bytearray()
        frame: bytes | None = None
        begun_ns = now = start_ns
        address = first
        for i in range(count):
            now = start_ns + (i + 1) * (byte_ns or 0)
            if DATAX0 <= address <= DATAZ1:
                if frame is None:
                    begun_ns = now
                    frame = self._data(now, settles=byte_ns is not None)
                data.append(frame[address - DATAX0 + 1])
            else:
                if frame is not None:
                    core.fifo.read(begun_ns, now, settles=byte_ns is not None)
                    frame = None
                data.append(self._register(address, now, running_on=i > 0))
            address = (address + step) & _ADDRESS
        if frame is not None:
            core.fifo.read(begun_ns, now + (byte_ns or 0), settles=byte_ns is not None)
        return bytes(data)

    def _read_sample(self, start_ns: int, byte_ns: int | None) -> bytes:
        """The six data registers, the chip being up to date."""
        settles = byte_ns is not None
        begun_ns = start_ns + (byte_ns or 0)
        frame = self._data(begun_ns, settles=settles)
        self._core.fifo.read(begun_ns, start_ns + 7 * (byte_ns or 0), settles=settles)
        return frame[1:]

    def _data(self, time_ns: int, *, settles: bool) -> bytes:
        """A zero and the data registers as a read finds them."""
        core = self._core
        if settles and core.fifo.mode != BYPASS:
            if core.fifo.settling(time_ns):
                self._report_pop("data read", time_ns)
            elif core.trigger_ns is not None and time_ns < core.trigger_ns + POP_NS:
                self._report_pop("data read after the trigger", time_ns)
        return core.fifo.shown(core.newest(), time_ns)

    def _register(self, address: int, time_ns: int, *, running_on: bool) -> int:
        core = self._core
        if address == INT_SOURCE:
            source = core.source()
            core.source_read()
            return source
        if address == FIFO_STATUS:
            if core.fifo.settling(time_ns):
                self._report_pop("FIFO_STATUS read", time_ns)
            return core.fifo.status(time_ns)
        if address == ACT_TAP_STATUS:
            return core.act_tap_status()
        return core.registers.read(address, time_ns, running_on=running_on)

    def _write(self, first: int, data: bytes | bytearray, start_ns: int, end_ns: int, step: int) -> None:
        self._settle_short_way()
        core = self._core
        core.advance(start_ns)
        for i, value in enumerate(data):
            core.write((first + step * i) & _ADDRESS, value, start_ns, end_ns)
        self._vetted = -1
        self._after_change(start_ns)

    def _settle_short_way(self) -> None:
        """Tell the core of reads that were cut out of the image."""
        if self._read_ns is not None:
            self._core.advance(self._read_ns)
            self._core.fifo.read(self._read_ns, self._read_ns, settles=False)
            self._read_ns = None
        self._lane.close()

    def _report_protocol(self, detail: str, time_ns: int) -> None:
        self.log.report(ReportKind.PROTOCOL, "SPI", detail, time_ns)

    def _report_pop(self, what: str, time_ns: int) -> None:
        detail = (
            f"{what} less than {POP_NS} ns after the end of a data read: undefined, the sample comes again"
        )
        self.log.report(ReportKind.TIMING, "FIFO", detail, time_ns)

    # -- what the other side makes of it ---------------------------------------------------------------

    @abstractmethod
    def _after_read(self, first: int, count: int, time_ns: int) -> None:
        """Registers were read."""

    @abstractmethod
    def _after_change(self, time_ns: int) -> None:
        """Registers were written, or the supply was switched."""


def _is_still(first: int, count: int) -> bool:
    """Whether none of the registers changes by itself or by being read."""
    end = first + count
    if end > FIFO_STATUS:
        return False
    return (
        end <= ACT_TAP_STATUS
        or (first > ACT_TAP_STATUS and end <= INT_SOURCE)
        or (first > DATAZ1 and end <= FIFO_STATUS)
        or (first > INT_SOURCE and end <= DATAX0)
    )
