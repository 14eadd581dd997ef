"""Power, bus interfaces and their rules (fact sheet section 1).

After power-up and after a soft reset the chip listens as an I²C slave; the first rising edge of chip select
makes it an SPI slave until the next reset, and the access that ends with that edge is lost. SPI: first byte
bit 7 = read, bits 6 … 0 the register, which then counts up.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Final

from boards.chips.bmi160.core import Core
from boards.chips.bmi160.i2c_face import I2cFace
from boards.chips.bmi160.pins import PIN_NAMES, OutputPins, PinNet, TagInputs
from boards.chips.bmi160.power import Sensor
from boards.chips.bmi160.register_map import FIFO_CONFIG_1, FIFO_DATA, IF_CONF, NV_CONF
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.world import ImuWorld
from hal.emulated.spi import SpiChip
from hal.emulated.virtual_time import VirtualTime

POWER_ON_NS: Final = 10_000_000
"""From power-on to the first register access."""

RESET_NS: Final = 1_000_000
"""Soft reset until the chip answers again."""

FASTEST_BYTE_NS: Final = 800
"""8 bits at 10 MHz."""

_BOTH: Final = (Sensor.GYRO, Sensor.ACCEL)

_UNDRIVEN: Final = 0xFF
"""What the bus shows while the chip is not there."""


class BusSide(SpiChip):
    """The part of the chip that a bus and a supply see; pins and events are `Bmi160`'s."""

    feels: ClassVar[str] = "imu"
    """The world that it asks."""
    measures = ("gyro", "accel", "temperature")
    """Of what the world tells."""
    spi_modes = (0, 3)
    """Clock modes that the part detects by itself (fact sheet section 1)."""

    __slots__ = (
        "_answers_from",
        "_burst_ns",
        "_core",
        "_outputs",
        "_phase_ns",
        "_powered",
        "_settled_ns",
        "_spi",
        "_tags",
        "_three_wire",
        "_time",
        "i2c",
        "log",
        "name",
        "pins",
    )

    def __init__(
        self,
        time: VirtualTime,
        world: ImuWorld,
        *,
        clock_error_ppm: float,
        phase_ns: int,
        sdo_high: bool,
        spi_wires: int,
        strict: bool,
        name: str,
    ) -> None:
        if spi_wires not in (3, 4):
            raise ValueError(f"{name}: spi_wires = {spi_wires}; the part has 3-wire and 4-wire SPI, e.g. 4")
        if phase_ns < 0:
            raise ValueError(f"{name}: phase_ns = {phase_ns}; it must not be negative, e.g. 12_000")
        self.name = name
        self.log = AccessLog(name, strict=strict)
        self.pins: dict[str, PinNet | None] = dict.fromkeys(PIN_NAMES)
        self.i2c = I2cFace(self, 0x69 if sdo_high else 0x68)
        self._time = time
        self._phase_ns = phase_ns
        self._three_wire = spi_wires == 3
        self._core = Core(world, self.log, round(clock_error_ppm * 1000.0))
        registers = self._core.registers.values
        self._outputs = OutputPins(self.pins, registers, self._core.data.interrupts)
        self._tags = TagInputs(self.pins, registers)
        self._core.data.inputs = self._tags.levels
        self._powered = True
        self._burst_ns: int | None = None
        """When the short way last read the data registers, while the data side does not know of it."""

    @property
    def reports(self) -> list[AccessReport]:
        """Accesses outside the documents or the model, the first of each kind with its time."""
        return self.log.reports

    # -- power -------------------------------------------------------------------------------------

    def power(self, on: bool) -> None:
        """Switch the supply, now. Without power the chip does not answer; with it, it starts from reset."""
        if on == self._powered:
            return
        self._powered = on
        if on:
            self._power_up(self._time.now)
        else:
            self._disarm()
            self._outputs.release()

    def brownout(self) -> None:
        """A dip of the supply, now: registers are lost and the chip starts from reset."""
        self.power(False)
        self.power(True)

    def _power_up(self, time_ns: int) -> None:
        self._settled_ns = time_ns + POWER_ON_NS
        self._restart(time_ns)

    def _restart(self, time_ns: int) -> None:
        """Everything from reset; the chip answers from `time_ns` on."""
        self._disarm()
        self._core.restart(time_ns + self._phase_ns)
        self._answers_from = time_ns
        self._spi = bool(self._core.registers.values[NV_CONF] & 0x01)
        self._burst_ns = None
        self._outputs.drive(time_ns)

    # -- SPI and I²C -------------------------------------------------------------------------------

    def _transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        if not self._answers(start_ns):
            return bytes((_UNDRIVEN,)) * len(mosi)
        if 0 < end_ns - start_ns < len(mosi) * FASTEST_BYTE_NS - 1:
            self._early("SPI clock faster than 10 MHz: undefined, served as if it were slower", start_ns)
        if not self._spi:
            self._spi = True
            return bytes(len(mosi))
        if not mosi:
            return b""
        address = mosi[0] & 0x7F
        if mosi[0] & 0x80:
            data = self.read_registers(address, len(mosi) - 1, start_ns)
            return b"\x00" + (data if self._drives_data() else bytes(len(data)))
        self.write_registers(address, bytes(mosi[1:]), start_ns, end_ns)
        return bytes(len(mosi))

    def _drives_data(self) -> bool:
        """Whether the chip sends on the wire that the board reads from."""
        three_wire = bool(self._core.registers.values[IF_CONF] & 0x01)
        return three_wire == self._three_wire

    def _answers(self, time_ns: int) -> bool:
        if self._powered and time_ns < self._answers_from:
            self._early("access before the chip had started", time_ns)
        return self._powered and time_ns >= self._answers_from

    def i2c_listens(self, time_ns: int) -> bool:
        """Whether the chip acknowledges its I²C address."""
        return self._answers(time_ns) and not self._spi

    def read_registers(self, address: int, count: int, time_ns: int) -> bytes:
        """A burst read as of `time_ns`."""
        if self._core.holds_still(address, count, time_ns) and time_ns >= self._settled_ns:
            return self._core.read_still(address, count, time_ns)
        self._before_access(time_ns)
        data = self._core.read(address, count, time_ns)
        if address <= FIFO_DATA < address + count:
            self._after_change(time_ns)
        else:
            self._after_read(time_ns)
        return data

    def write_registers(self, address: int, data: bytes, start_ns: int, end_ns: int) -> None:
        """A burst write on the wire from `start_ns` to `end_ns`."""
        if not data:
            return
        self._before_access(start_ns)
        self._core.write(address, data, start_ns, end_ns)
        if self._core.commands.reset_requested:
            self._restart(end_ns + RESET_NS)
        elif self._core.registers.values[FIFO_CONFIG_1] & 0x0C:
            self._tags.follow(start_ns)
        self._after_change(start_ns)

    def _before_access(self, time_ns: int) -> None:
        if time_ns < self._settled_ns:
            self._early(f"access less than {POWER_ON_NS} ns after power-on", time_ns)
        self._settle_short_way()

    def _settle_short_way(self) -> None:
        """Tell the data side of the last burst that was cut out of the image."""
        if self._burst_ns is not None:
            self._core.data.data_read(_BOTH, self._burst_ns)
            self._burst_ns = None

    def _early(self, detail: str, time_ns: int) -> None:
        self.log.report(ReportKind.TIMING, "any", detail, time_ns)

    # -- what the other side makes of it -------------------------------------------------------------

    @abstractmethod
    def _after_read(self, time_ns: int) -> None:
        """Registers were read in the general way."""

    @abstractmethod
    def _after_change(self, time_ns: int) -> None:
        """Registers were written or the FIFO was read."""

    @abstractmethod
    def _disarm(self) -> None:
        """Forget events and the short way."""
