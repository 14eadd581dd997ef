"""The ADXL345 as a part on a board: the common read in a short way, interrupt pins and their events.

The common access, the six data bytes in bypass mode, is cut out of the sampler's block image: one slice
while the sample is still the newest, one search when it is not. With a FIFO that burst and FIFO_STATUS are
served by `FifoLane`. Everything else takes the general way (`bus_side`).

Events exist only while somebody follows a pin on which the firmware has put an enabled source. For data
ready alone, the usual case, that is one event a sample; the others are foreseen, and one event comes when
the pin can first change.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import Final

from boards.chips.adxl345.bus_side import CS_HIGH_NS, FASTEST_BYTE_NS, BusSide
from boards.chips.adxl345.fifo import BYPASS, POP_NS
from boards.chips.adxl345.pin_net import PinNet
from boards.chips.adxl345.register_map import (
    DATA,
    DATA_FORMAT,
    DATA_READY,
    DEVID,
    FIFO_STATUS,
    INT_ENABLE,
    INT_INVERT,
    INT_MAP,
    INT_SOURCE,
    LIVE,
)
from boards.chips.adxl345.sample_kernels import STRIDE
from boards.chips.world import ImuWorld
from hal.emulated.virtual_time import Event, VirtualTime

_BURST: Final = 0xF2
"""Read, several bytes, from DATAX0 on."""
_STATUS: Final = 0xB9
"""Read FIFO_STATUS."""
_SHORTEST_STATUS_NS: Final = 2 * FASTEST_BYTE_NS
_PIN_NAMES: Final = ("INT1", "INT2")


class Adxl345(BusSide):
    """One ADXL345.

    `clock_error_ppm`: how much its oscillator is fast. `supply_v`: 2.0 … 3.6, which sensitivity, offset and
    self-test depend on. `sdo_high`: ALT ADDRESS pin, I²C address 0x1D instead of 0x53. `spi_wires`: 4, or 3
    when the board joins data in and out. `strict`: reports are raised as UndocumentedAccessError.

    `pins` takes the nets of INT1 and INT2. `i2c` is the I²C face. `reports` tells what the firmware did
    that the documents or this model do not cover.
    """

    __slots__ = (
        "_active",
        "_asserted",
        "_event",
        "_event_times",
        "_fast_to",
        "_frame",
        "_image",
        "_mask",
        "_net",
        "_next_ns",
        "_next_row",
        "_times",
    )

    def __init__(
        self,
        time: VirtualTime,
        world: ImuWorld,
        *,
        clock_error_ppm: float = 0.0,
        supply_v: float = 2.5,
        sdo_high: bool = False,
        spi_wires: int = 4,
        strict: bool = False,
        name: str = "ADXL345",
    ) -> None:
        super().__init__(
            time,
            world,
            clock_error_ppm=clock_error_ppm,
            supply_v=supply_v,
            sdo_high=sdo_high,
            spi_wires=spi_wires,
            strict=strict,
            name=name,
        )
        self._event: Event | None = None
        self._mask = 0
        """Sources on the pins that are followed."""
        self._net: PinNet | None = None
        """The pin of the data-ready event; None while the event is of the general kind."""
        self._active = True
        self._asserted = False
        """Whether that pin is active."""
        self._event_times: list[int] = []
        self._next_row = 0
        """Of the next data-ready event; −1 before the first."""
        self._fast_to = self._next_ns = 0
        """The short way serves reads before `_fast_to`, and `_frame` those before `_next_ns`; 0: closed."""
        self._frame = b""
        self._times: list[int] = []
        self._image = b""

    # -- the short way -------------------------------------------------------------------------------

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period; see `hal.emulated.spi.SpiSlave`."""
        length = len(mosi)
        if length == STRIDE and mosi[0] == _BURST:
            if end_ns - start_ns != self._vetted or (
                start_ns < self._ready_ns and start_ns != self._ended_ns
            ):
                return self._transaction(mosi, start_ns, end_ns)
            if start_ns >= self._fast_to:
                return self._pop(start_ns, end_ns) or self._transaction(mosi, start_ns, end_ns)
        elif length == 2 and mosi[0] == _STATUS and self._is_proven(start_ns, end_ns):
            return self._tell_status(start_ns, end_ns) or self._transaction(mosi, start_ns, end_ns)
        else:
            return self._transaction(mosi, start_ns, end_ns)
        self._read_ns = start_ns
        self._ended_ns = end_ns
        self._ready_ns = end_ns + CS_HIGH_NS
        if start_ns >= self._next_ns:
            self._find_row(start_ns)
        if self._asserted:
            self._asserted = False
            self._net.set(not self._active)  # type: ignore[union-attr]
        return self._frame

    def _pop(self, start_ns: int, end_ns: int) -> bytes | None:
        """The same read where it takes a sample out of the FIFO; None when there is more to it."""
        frame = self._lane.pop(start_ns, end_ns)
        if frame is not None:
            self._ended_ns = end_ns
            self._ready_ns = end_ns + CS_HIGH_NS
        return frame

    def _is_proven(self, start_ns: int, end_ns: int) -> bool:
        """Whether a read of a register keeps all rules. One of the data that kept them has shown that the
        chip drives the wire."""
        fast_enough = self._vetted > 0 and end_ns - start_ns >= _SHORTEST_STATUS_NS
        return fast_enough and (start_ns >= self._ready_ns or start_ns == self._ended_ns)

    def _tell_status(self, start_ns: int, end_ns: int) -> bytes | None:
        """FIFO_STATUS, which changes nothing; None when there is more to it."""
        answer = self._lane.status(start_ns)
        if answer is not None:
            self._ended_ns = end_ns
            self._ready_ns = end_ns + CS_HIGH_NS
        return answer

    def i2c_read(self, address: int, count: int, time_ns: int) -> bytes:
        """A burst read by I²C; the six data bytes take the short way too."""
        if address != DATA[0] or count != len(DATA) or self._too_fast_for_i2c:
            return super().i2c_read(address, count, time_ns)
        if time_ns >= self._fast_to:
            frame = self._lane.pop(time_ns, time_ns - POP_NS)
            return frame[1:] if frame is not None else super().i2c_read(address, count, time_ns)
        self._read_ns = time_ns
        if time_ns >= self._next_ns:
            self._find_row(time_ns)
        if self._asserted:
            self._asserted = False
            self._net.set(not self._active)  # type: ignore[union-attr]
        return self._frame[1:]

    def _find_row(self, time_ns: int) -> None:
        """Move the short way to the newest sample at a time inside the block."""
        row = bisect_right(self._times, time_ns) - 1
        self._frame = self._image[row * STRIDE : (row + 1) * STRIDE]
        self._next_ns = self._times[row + 1]

    def _arm_short_way(self, time_ns: int) -> None:
        """Let the read of the data be served from the block, where nothing but time can change it."""
        core = self._core
        self._fast_to = self._next_ns = 0
        self._lane.close()
        if not self.powered or not core.steady:
            return
        if self._net is None and self._mask & LIVE:
            return  # a read ends an assertion of the general kind
        if core.fifo.mode != BYPASS:
            self._lane.open()
            return
        sampler = core.sampler
        sampler.cover(sampler.clock.tick(time_ns))
        if not sampler.times or not sampler.times[0] <= time_ns < sampler.times[-1]:
            return
        self._times, self._image = sampler.times, sampler.image
        self._fast_to = self._times[-1]
        self._find_row(time_ns)

    # -- defects -------------------------------------------------------------------------------------

    def pretend_id(self, device_id: int | None) -> None:
        """Answer with another DEVID; None: with its own again."""
        self._core.registers.pretend(DEVID, device_id)

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
        self._after_change(now)

    # -- pins and events -----------------------------------------------------------------------------

    def _after_read(self, first: int, count: int, time_ns: int) -> None:
        """A read of data or INT_SOURCE may have ended an assertion; the next may take the short way."""
        if first + count <= INT_SOURCE or (first > DATA[-1] and first + count <= FIFO_STATUS):
            return
        if self._net is None:
            if self._mask:
                self._schedule(time_ns)
        elif self._asserted and not self._core.fifo.data_ready:
            self._asserted = False
            self._net.set(not self._active)
        self._arm_short_way(time_ns)

    def _after_change(self, time_ns: int) -> None:
        self._schedule(time_ns)
        self._arm_short_way(time_ns)

    def _listener_arrived(self) -> None:
        self._settle_short_way()
        self._core.advance(self._time.now)
        self._after_change(self._time.now)

    def _watched(self) -> list[int]:
        """Pins that somebody follows; the others call when somebody comes."""
        watched = []
        for pin, name in enumerate(_PIN_NAMES):
            net = self.pins[name]
            if net is not None:
                net.on_first_listener = self._listener_arrived
                if net.listened:
                    watched.append(pin)
        return watched

    def _drive(self) -> None:
        """Bring the followed pins to their levels; without supply they are low."""
        asserted = self._core.asserted()
        inverted = bool(self._core.registers.values[DATA_FORMAT] & INT_INVERT)
        for pin in self._watched():
            self.pins[_PIN_NAMES[pin]].set(self.powered and asserted[pin] != inverted)  # type: ignore[union-attr]

    def _sources(self, pin: int) -> int:
        values = self._core.registers.values
        mapped = values[INT_MAP] if pin else ~values[INT_MAP]
        return values[INT_ENABLE] & mapped & 0xFF

    def _schedule(self, time_ns: int) -> None:
        """Drive the pins and see to the next event."""
        if self._event is not None:
            self._event.cancel()
            self._event = None
        self._net, self._asserted, self._mask = None, False, 0
        watched = self._watched()
        if not watched:
            return
        self._drive()
        if not self.powered:
            return
        busy = [pin for pin in watched if self._sources(pin)]
        for pin in busy:
            self._mask |= self._sources(pin)
        if self._mask == DATA_READY and self._core.plain_bypass:
            self._start_data_ready(busy[0], time_ns)
            return
        due = self._core.next_change(self._mask) if self._mask else None
        if due is not None:
            self._event = self._time.at(max(due, self._time.now), self._look)

    def _look(self) -> int | None:
        """Event of the general kind: something may have happened."""
        self._settle_short_way()
        self._core.advance(self._time.now)
        self._drive()
        if self._watched():
            due = self._core.next_change(self._mask)
            if due is not None:
                return max(due, self._time.now)
        self._event = None
        return None

    # -- data ready alone: one event a sample --------------------------------------------------------

    def _start_data_ready(self, pin: int, time_ns: int) -> None:
        core = self._core
        self._net = self.pins[_PIN_NAMES[pin]]
        self._active = not core.registers.values[DATA_FORMAT] & INT_INVERT
        self._asserted = core.fifo.data_ready
        sampler = core.sampler
        tick = sampler.clock.tick(time_ns)
        self._next_row = -1
        self._event = self._time.at(sampler.instant_after(tick, 1), self._data_ready)

    def _data_ready(self) -> int | None:
        """Event: a new sample."""
        net = self._net
        assert net is not None
        row = self._next_row
        if row < 0 or row + 1 >= len(self._event_times):
            if not net.listened:
                self._settle_short_way()
                self._core.advance(self._time.now)
                self._schedule(self._time.now)
                return None
            row = self._next_block()
        next_ns = self._event_times[row + 1]
        self._next_row = row + 1
        if self._fast_to and self._times is self._event_times:
            self._frame = self._image[row * STRIDE : (row + 1) * STRIDE]
            self._next_ns = next_ns
        if not self._asserted:
            self._asserted = True
            net.set(self._active)
        return next_ns

    def _next_block(self) -> int:
        """Go on in the block that holds the sample of now; returns its row."""
        now = self._time.now
        self._settle_short_way()
        self._core.advance(now)
        sampler = self._core.sampler
        sampler.cover(sampler.clock.tick(now))
        self._arm_short_way(now)
        self._event_times = sampler.times
        return bisect_right(self._event_times, now) - 1
