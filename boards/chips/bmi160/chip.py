"""The BMI160 as a part on a board: power, bus interfaces, interrupt pins.

Bus rules (fact sheet section 1): after power-up and after a soft reset the chip listens as an I²C slave;
the first rising edge of chip select makes it an SPI slave until the next reset, and the access that ends
with that edge is lost. SPI: first byte bit 7 = read, bits 6 … 0 the register, which then counts up.

The common access, sixteen bytes from 0x0C on (address byte, gyroscope, accelerometer, sensor time), is cut
out of the sampler's block image without further ado; everything else takes the general way.
"""

from __future__ import annotations

from bisect import bisect_right

from boards.chips.bmi160.block_kernels import STRIDE
from boards.chips.bmi160.core import RESET_NS, Core
from boards.chips.bmi160.i2c_face import I2cFace
from boards.chips.bmi160.interrupts import NON_LATCHED, Source
from boards.chips.bmi160.pins import PIN_NAMES, OutputPins, PinNet, TagInputs
from boards.chips.bmi160.power import Sensor
from boards.chips.bmi160.register_map import FIFO_CONFIG_1, IF_CONF, NV_CONF
from boards.chips.bmi160.sensor_clock import COUNTER_MASK
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.world import ImuWorld
from hal.emulated.virtual_time import Event, VirtualTime

POWER_ON_NS = 10_000_000
"""From power-on to the first register access."""

_BURST = 0x8C
"""Read from register 0x0C."""
_BURST_LENGTH = 16

_NO_POWER = 0xFF
"""What the bus shows when the chip does not drive it."""


class Bmi160:
    """One BMI160.

    `clock_error_ppm`: how much its oscillator is fast. `start_ns`: when its supply comes up. `phase_ns`:
    how much later its oscillator starts. `sdo_high`: address pin, 0x69 instead of 0x68. `spi_wires`: 4, or
    3 when the board joins data in and out. `strict`: reports are raised as UndocumentedAccessError.

    `pins` takes the nets of INT1 and INT2. `i2c` is the I²C face. `reports` tells what the firmware did
    that the documents or this model do not cover.
    """

    __slots__ = (
        "_active",
        "_answers_from",
        "_at",
        "_burst_ns",
        "_core",
        "_denominator",
        "_event",
        "_event_times",
        "_expect_read",
        "_fast_to",
        "_image",
        "_net",
        "_next_ns",
        "_next_row",
        "_numerator",
        "_outputs",
        "_phase_ns",
        "_powered",
        "_pulse_ends",
        "_pulsing",
        "_settled_ns",
        "_spi",
        "_tags",
        "_three_wire",
        "_tick_bias",
        "_time",
        "_times",
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
        clock_error_ppm: float = 0.0,
        start_ns: int = 0,
        phase_ns: int = 0,
        sdo_high: bool = False,
        spi_wires: int = 4,
        strict: bool = False,
        name: str = "BMI160",
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
        self._event: Event | None = None
        self._pulsing = self._pulse_ends = self._expect_read = False
        self._net: PinNet | None = None
        self._active = True
        self._next_row = 0
        self._burst_ns: int | None = None
        self._fast_to = 0
        self._times: list[int] = []
        self._image = b""
        self._at = self._next_ns = self._tick_bias = 0
        self._numerator = self._denominator = 1
        self._event_times: list[int] = []
        self._start(start_ns, start_ns)

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
            self._start(self._time.now, self._time.now)
        else:
            self._disarm()
            self._outputs.release()

    def brownout(self) -> None:
        """A dip of the supply, now: registers are lost and the chip starts from reset."""
        self.power(False)
        self.power(True)

    def _start(self, time_ns: int, power_on_ns: int | None) -> None:
        """Power-up at `time_ns`, or end of a soft reset (then `power_on_ns` stays)."""
        self._disarm()
        self._core.restart(time_ns + self._phase_ns)
        self._answers_from = time_ns
        if power_on_ns is not None:
            self._settled_ns = power_on_ns + POWER_ON_NS
        self._spi = bool(self._core.registers.values[NV_CONF] & 0x01)
        self._burst_ns = None
        self._outputs.drive(time_ns)

    # -- SPI ---------------------------------------------------------------------------------------

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period; see `hal.emulated.spi.SpiSlave`."""
        if start_ns < self._fast_to and mosi[0] == _BURST and len(mosi) == _BURST_LENGTH:
            if start_ns >= self._next_ns:
                self._find_row(start_ns)
            self._burst_ns = start_ns
            if self._pulsing:
                self._pulsing = False
                self._expect_read = True
                self._net.set(not self._active)  # type: ignore[union-attr]
            at = self._at
            tick = (start_ns * self._denominator + self._tick_bias) // self._numerator & COUNTER_MASK
            return self._image[at : at + STRIDE] + tick.to_bytes(3, "little")
        return self._transaction(mosi, start_ns, end_ns)

    def _find_row(self, time_ns: int) -> None:
        """Move the short way to the newest sample at a time inside the block."""
        row = bisect_right(self._times, time_ns) - 1
        self._at = row * STRIDE
        self._next_ns = self._times[row + 1]

    def _transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        if not self._powered or start_ns < self._answers_from:
            if self._powered:
                self._early("SPI access before the chip had started", start_ns)
            return bytes((_NO_POWER,)) * len(mosi)
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

    # -- both interfaces ---------------------------------------------------------------------------

    def i2c_listens(self, time_ns: int) -> bool:
        """Whether the chip acknowledges its I²C address."""
        if self._powered and time_ns < self._answers_from:
            self._early("I2C access before the chip had started", time_ns)
        return self._powered and time_ns >= self._answers_from and not self._spi

    def read_registers(self, address: int, count: int, time_ns: int) -> bytes:
        """A burst read as of `time_ns`."""
        self._settle(time_ns)
        data = self._core.read(address, count, time_ns)
        self._after_read(time_ns)
        return data

    def write_registers(self, address: int, data: bytes, start_ns: int, end_ns: int) -> None:
        """A burst write on the wire from `start_ns` to `end_ns`."""
        if not data:
            return
        self._settle(start_ns)
        self._core.write(address, data, start_ns, end_ns)
        if self._core.reset_requested:
            self._start(end_ns + RESET_NS, None)
        elif self._core.registers.values[FIFO_CONFIG_1] & 0x0C:
            self._tags.follow(start_ns)
        self._schedule(start_ns)

    def _settle(self, time_ns: int) -> None:
        """Before an access: what the short way did, and the rule about power-up."""
        if time_ns < self._settled_ns:
            self._early(f"access less than {POWER_ON_NS} ns after power-on", time_ns)
        self._settle_short_way()

    def _early(self, detail: str, time_ns: int) -> None:
        self.log.report(ReportKind.TIMING, "any", detail, time_ns)

    # -- pins and events ---------------------------------------------------------------------------

    def _after_read(self, time_ns: int) -> None:
        """A read may have ended an assertion, and its block of samples may serve the short way now."""
        if self._net is None:
            self._outputs.drive(time_ns)
        elif self._pulsing and not self._core.data.interrupts.active(Source.DATA_READY, time_ns):
            self._pulsing = False
            self._expect_read = True
            self._net.set(not self._active)
        self._arm_short_way(time_ns)

    def _arm_short_way(self, time_ns: int) -> None:
        """Let the common burst read be served from the block, where nothing but time can change it."""
        data = self._core.data
        sampler = data.sampler
        self._fast_to = 0
        if not self._spi or not self._drives_data() or time_ns < self._settled_ns:
            return
        if sampler.first_tick == sampler.end_tick or not sampler.times[0] <= time_ns < sampler.times[-1]:
            return
        if self._event is not None and self._net is None and Source.DATA_READY.enabled(data.registers):
            return  # a read ends a pulse of the general kind
        due = self._core.next_due
        self._times, self._image = sampler.times, sampler.image
        self._numerator, self._denominator = data.clock.numerator, data.clock.denominator
        self._tick_bias = (1 - data.clock.start_ns) * self._denominator - 1
        self._fast_to = sampler.times[-1] if due is None else min(sampler.times[-1], due)
        self._find_row(time_ns)

    def _disarm(self) -> None:
        if self._event is not None:
            self._event.cancel()
            self._event = None
        self._net = None
        self._pulsing = self._pulse_ends = self._expect_read = False
        self._fast_to = 0

    def _schedule(self, time_ns: int) -> None:
        """Bring the pins up to date and choose the event that keeps them so."""
        self._disarm()
        if not self._powered:
            return
        core = self._core
        core.advance(time_ns)
        self._outputs.drive(time_ns)
        watched = self._outputs.watched(self._listener_arrived)
        if any(self._outputs.sources(pin) for pin in watched):
            if self._only_data_ready(watched):
                self._start_data_ready(watched[0], time_ns)
            else:
                next_ns = self._next_event(time_ns)
                if next_ns is not None:
                    self._event = self._time.at(next_ns, self._look)
        self._arm_short_way(time_ns)

    def _listener_arrived(self) -> None:
        self._schedule(self._time.now)

    def _next_event(self, time_ns: int) -> int | None:
        core = self._core
        times = (core.next_due, core.data.next_sample(time_ns), core.data.interrupts.next_change(time_ns))
        return min((time for time in times if time is not None), default=None)

    def _look(self) -> int | None:
        """Event of the general kind: something may have become due or been sampled."""
        now = self._time.now
        self._settle_short_way()
        self._core.advance(now)
        self._outputs.drive(now)
        watched = self._outputs.watched(self._listener_arrived)
        if not watched or self._only_data_ready(watched):
            self._schedule(now)
            return None
        self._arm_short_way(now)
        return self._next_event(now)

    def _settle_short_way(self) -> None:
        """Tell the data side of the last burst that was cut out of the image."""
        if self._burst_ns is not None:
            self._core.data.data_read(Sensor.GYRO, self._burst_ns)
            self._core.data.data_read(Sensor.ACCEL, self._burst_ns)
            self._burst_ns = None

    # -- data ready alone: one event a sample --------------------------------------------------------

    def _only_data_ready(self, watched: list[int]) -> bool:
        """Whether one pin shows non-latched data ready of steady sampling and nothing else."""
        data = self._core.data
        streams = [stream for stream in (data.gyro_stream, data.accel_stream) if stream is not None]
        return (
            len(watched) == 1
            and self._outputs.sources(watched[0]) == [Source.DATA_READY]
            and data.interrupts.mode == NON_LATCHED
            and self._core.next_due is None
            and bool(streams)
            and min(stream.period for stream in streams) == data.sampler.grid
        )

    def _start_data_ready(self, pin: int, time_ns: int) -> None:
        data = self._core.data
        self._net = self.pins[PIN_NAMES[pin]]
        self._active = self._outputs.active_level(pin)
        self._pulsing = data.interrupts.active(Source.DATA_READY, time_ns)
        sampler = data.sampler
        sampler.cover(max(data.clock.tick(time_ns), sampler.first_tick))
        self._event_times = sampler.times
        self._next_row = bisect_right(sampler.times, time_ns)
        first = sampler.times[self._next_row]
        if self._pulsing:
            self._pulse_ends = True
            first = data.interrupts.next_change(time_ns) or first
        self._event = self._time.at(first, self._data_ready)

    def _data_ready(self) -> int:
        """Event: a new sample. The pulse ends when the data are read; only a reader that does not read in
        time makes the end of the pulse an event of its own."""
        net = self._net
        assert net is not None
        if self._pulse_ends:
            self._pulse_ends = False
            if self._pulsing:
                self._pulsing = False
                net.set(not self._active)
            return self._event_times[self._next_row]
        times = self._event_times
        row = self._next_row
        if row == len(times) - 1:
            self._next_block()
            times, row = self._event_times, 0
        next_ns = times[row + 1]
        self._next_row = row + 1
        self._at = row * STRIDE
        self._next_ns = next_ns
        if self._pulsing:
            self._expect_read = False
            net.set(not self._active)
        self._pulsing = True
        net.set(self._active)
        if self._expect_read:
            return next_ns
        self._pulse_ends = True
        return self._time.now + self._core.data.interrupts.pulse_ns

    def _next_block(self) -> None:
        now = self._time.now
        self._settle_short_way()
        self._core.advance(now)
        sampler = self._core.data.sampler
        sampler.cover(sampler.clock.tick(now))
        self._event_times = sampler.times
        self._arm_short_way(now)
