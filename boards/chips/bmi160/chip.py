"""The BMI160 as a part on a board: the common read in a short way, interrupt pins and their events.

The common access, sixteen bytes from 0x0C on (address byte, gyroscope, accelerometer, sensor time), is cut
out of the sampler's block image without further ado: one slice while the sensor time is still that of the
sample, which is how a reader that data ready has woken finds it; later than that the sensor time is put in
anew. Everything else takes the general way (`bus_side`).

Events exist only while somebody follows a pin that the firmware drives from an enabled source. For
non-latched data ready alone, the usual case, that is one event a sample.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from typing import Final

from boards.chips.bmi160.block_kernels import DATA_END, STRIDE
from boards.chips.bmi160.bus_side import BusSide
from boards.chips.bmi160.interrupts import NON_LATCHED, Source
from boards.chips.bmi160.pins import PIN_NAMES, PinNet
from boards.chips.bmi160.register_map import CHIP_ID
from boards.chips.bmi160.sensor_clock import COUNTER_MASK
from boards.chips.world import ImuWorld
from hal.emulated.virtual_time import Event, VirtualTime

_BURST: Final = 0x8C
"""Read from register 0x0C."""
_BURST_LENGTH: Final = 16


class Bmi160(BusSide):
    """One BMI160.

    `clock_error_ppm`: how much its oscillator is fast. `start_ns`: when its supply comes up. `phase_ns`:
    how much later its oscillator starts. `sdo_high`: address pin, 0x69 instead of 0x68. `spi_wires`: 4, or
    3 when the board joins data in and out. `strict`: reports are raised as UndocumentedAccessError.

    `pins` takes the nets of INT1 and INT2. `i2c` is the I²C face. `reports` tells what the firmware did
    that the documents or this model do not cover.
    """

    __slots__ = (
        "_active",
        "_denominator",
        "_event",
        "_expect_read",
        "_fast_to",
        "_feed",
        "_frame",
        "_fresh_to",
        "_idle",
        "_image",
        "_net",
        "_next_ns",
        "_numerator",
        "_open",
        "_pulse_ends",
        "_pulsing",
        "_tick_bias",
        "_times",
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
        super().__init__(
            time,
            world,
            clock_error_ppm=clock_error_ppm,
            phase_ns=phase_ns,
            sdo_high=sdo_high,
            spi_wires=spi_wires,
            strict=strict,
            name=name,
        )
        self._event: Event | None = None
        self._net: PinNet | None = None
        """The pin of the data-ready event; None while the event is of the general kind."""
        self._active, self._idle = True, False
        """Levels of that pin."""
        self._pulsing = self._pulse_ends = self._expect_read = False
        self._open = False
        """Whether the short way is open."""
        self._fast_to = self._fresh_to = 0
        """Before which times (ns) it serves reads at all, and those that find the newest sample's sensor
        time; 0 while it is closed."""
        self._times: list[int] = []
        self._image = self._frame = b""
        """Of the block, and in it of the newest sample."""
        self._next_ns = 0
        """When the next sample comes."""
        self._feed: Iterator[tuple[int, int, bytes]] = iter(())
        """Of the coming data-ready events `_next_ns`, `_fresh_to` and `_frame`."""
        self._numerator = self._denominator = 1
        self._tick_bias = 0
        self._power_up(start_ns)

    # -- the short way -------------------------------------------------------------------------------

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period; see `hal.emulated.spi.SpiSlave`."""
        if start_ns < self._fresh_to and len(mosi) == _BURST_LENGTH and mosi[0] == _BURST:
            self._burst_ns = start_ns
            if self._pulsing:  # `_end_by_read`
                self._pulsing = False
                self._expect_read = True
                self._net.set(self._idle)  # type: ignore[union-attr]
            return self._frame
        if start_ns >= self._fast_to or len(mosi) != _BURST_LENGTH or mosi[0] != _BURST:
            return self._transaction(mosi, start_ns, end_ns)
        return self._later_burst(start_ns)

    def _end_by_read(self) -> None:
        """A read ends the pulse of data ready."""
        self._pulsing = False
        self._expect_read = True
        self._net.set(self._idle)  # type: ignore[union-attr]

    def _later_burst(self, time_ns: int) -> bytes:
        """The newest sample at a time inside the block, with the sensor time of that moment."""
        self._burst_ns = time_ns
        if self._pulsing:
            self._end_by_read()
        if time_ns >= self._next_ns:
            self._find_row(time_ns)
        tick = (time_ns * self._denominator + self._tick_bias) // self._numerator & COUNTER_MASK
        return self._frame[:DATA_END] + tick.to_bytes(3, "little")

    def _find_row(self, time_ns: int) -> None:
        """Move the short way to the newest sample at a time inside the block."""
        row = bisect_right(self._times, time_ns) - 1
        self._frame = self._image[row * STRIDE : (row + 1) * STRIDE]
        self._next_ns = self._times[row + 1]
        self._fresh_to = min(self._times[row] + self._numerator // self._denominator, self._fast_to)

    def _arm_short_way(self, time_ns: int) -> None:
        """Let the common burst read be served from the block, where nothing but time can change it."""
        data = self._core.data
        sampler = data.sampler
        self._close_short_way()
        if not self._spi or not self._drives_data() or time_ns < self._settled_ns:
            return
        if sampler.first_tick == sampler.end_tick or not sampler.times[0] <= time_ns < sampler.times[-1]:
            return
        if self._event is not None and self._net is None and Source.DATA_READY.enabled(data.registers):
            return  # a read ends a pulse of the general kind
        due = self._core.commands.next_due
        self._times, self._image = sampler.times, sampler.image
        self._numerator, self._denominator = data.clock.numerator, data.clock.denominator
        self._tick_bias = (1 - data.clock.start_ns) * self._denominator - 1
        self._fast_to = sampler.times[-1] if due is None else min(sampler.times[-1], due)
        self._open = True
        self._find_row(time_ns)

    def _close_short_way(self) -> None:
        self._open = False
        self._fast_to = self._fresh_to = 0

    def pretend_id(self, chip_id: int | None) -> None:
        """Answer with another CHIP_ID; None: with its own again."""
        self._core.registers.pretend(CHIP_ID, chip_id)

    def set_clock_error(self, ppm: float) -> None:
        """Its oscillator runs fast by so much from now on."""
        self._disturb(round(ppm * 1000.0))

    def look_anew(self) -> None:
        """Ask the world again for the samples to come: it has changed."""
        self._disturb(None)

    def _disturb(self, error_ppb: int | None) -> None:
        now = self._time.now
        self._settle_short_way()
        self._core.look_anew(now, error_ppb)
        self._schedule(now)

    # -- pins and events -----------------------------------------------------------------------------

    def _after_read(self, time_ns: int) -> None:
        """A read may have ended an assertion, and its block of samples may serve the short way now."""
        if self._net is None:
            self._outputs.drive(time_ns)
        elif self._pulsing and not self._core.data.interrupts.active(Source.DATA_READY, time_ns):
            self._end_by_read()
        self._arm_short_way(time_ns)

    def _after_change(self, time_ns: int) -> None:
        """A write may have changed anything, a read of the FIFO when it will be full again."""
        self._schedule(time_ns)

    def _disarm(self) -> None:
        if self._event is not None:
            self._event.cancel()
            self._event = None
        self._net = None
        self._pulsing = self._pulse_ends = self._expect_read = False
        self._close_short_way()

    def _schedule(self, time_ns: int) -> None:
        """Bring the pins up to date and choose the event that keeps them so."""
        self._disarm()
        if not self._powered:
            return
        self._core.advance(time_ns)
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
        self._settle_short_way()
        self._schedule(self._time.now)

    def _next_event(self, time_ns: int) -> int | None:
        core = self._core
        times = (
            core.commands.next_due,
            core.data.next_sample(time_ns),
            core.data.interrupts.next_change(time_ns),
        )
        return min((time for time in times if time is not None), default=None)

    def _look(self) -> int | None:
        """Event of the general kind: something may have become due or been sampled."""
        now = self._time.now
        core = self._core
        due = core.commands.next_due
        self._settle_short_way()
        core.advance(now)
        if (due is not None and due <= now) or not self._outputs.watched(self._listener_arrived):
            self._schedule(now)
            return None
        self._outputs.drive(now)
        self._arm_short_way(now)
        return self._next_event(now)

    # -- data ready alone: one event a sample --------------------------------------------------------

    def _only_data_ready(self, watched: list[int]) -> bool:
        """Whether one pin shows non-latched data ready of steady sampling and nothing else."""
        data = self._core.data
        streams = [stream for stream in (data.gyro_stream, data.accel_stream) if stream is not None]
        return (
            len(watched) == 1
            and self._outputs.sources(watched[0]) == [Source.DATA_READY]
            and data.interrupts.mode == NON_LATCHED
            and self._core.commands.next_due is None
            and bool(streams)
            and min(stream.period for stream in streams) == data.sampler.grid
        )

    def _start_data_ready(self, pin: int, time_ns: int) -> None:
        data = self._core.data
        self._net = self.pins[PIN_NAMES[pin]]
        self._active = self._outputs.active_level(pin)
        self._idle = not self._active
        self._pulsing = data.interrupts.active(Source.DATA_READY, time_ns)
        sampler = data.sampler
        sampler.cover(max(data.clock.tick(time_ns), sampler.first_tick))
        row = bisect_right(sampler.times, time_ns)
        self._feed_from(row)
        self._next_ns = first = sampler.times[row]
        if self._pulsing:
            self._pulse_ends = True
            first = data.interrupts.next_change(time_ns) or first
        self._event = self._time.at(first, self._data_ready)

    def _feed_from(self, row: int) -> None:
        """The block's samples from `row` on, as their events want them."""
        data = self._core.data
        sampler = data.sampler
        fresh_to = sampler.instants[row:] + data.clock.numerator // data.clock.denominator
        nexts = sampler.times[row + 1 :]
        self._feed = zip(nexts, fresh_to.tolist(), sampler.frames(row), strict=False)

    def _data_ready(self) -> int | None:
        """Event: a new sample. The pulse ends when the data are read; only for a reader that does not read
        in time its end is an event of its own."""
        if self._pulse_ends:
            return self._end_pulse()
        try:
            self._next_ns, self._fresh_to, self._frame = next(self._feed)
        except StopIteration:
            return self._begin_block()
        if not self._open:
            self._fresh_to = 0
        net = self._net
        if self._pulsing:
            self._expect_read = False
            net.set(self._idle)  # type: ignore[union-attr]
        self._pulsing = True
        net.set(self._active)  # type: ignore[union-attr]
        if self._expect_read:
            return self._next_ns
        self._pulse_ends = True
        return self._time.now + self._core.data.interrupts.pulse_ns

    def _end_pulse(self) -> int:
        """Event: nobody read in time. Returns when the next sample comes."""
        self._pulse_ends = False
        if self._pulsing:
            self._pulsing = False
            self._net.set(self._idle)  # type: ignore[union-attr]
        return self._next_ns

    def _begin_block(self) -> int | None:
        """Event: a new sample, the first of the next block."""
        now = self._time.now
        if not self._net.listened:  # type: ignore[union-attr]
            self._schedule(now)
            return None
        self._settle_short_way()
        self._core.advance(now)
        sampler = self._core.data.sampler
        sampler.cover(sampler.clock.tick(now))
        self._arm_short_way(now)
        self._feed_from(0)
        return self._data_ready()
