"""DIO1 … DIO4 and RST: data ready, alarm, general purpose, external clock, reset.

A DIO has one function, in this order: external clock (DIO4), data ready, alarm (DIO1 or DIO2), general
purpose. Events exist only while somebody follows a pin with data ready or an alarm on it.
"""

from __future__ import annotations

from collections.abc import Callable

from boards.chips.adis16407 import register_map as reg
from boards.chips.adis16407.core import Core
from boards.chips.adis16407.sampler import FAR
from boards.chips.registers import AccessLog, ReportKind
from hal.emulated.pins import Net
from hal.emulated.virtual_time import Event, VirtualTime

PULSE_NS = 100_000
"""Of data ready; a choice, the sheet has no figure."""
SHORTEST_CLOCK_NS = 909_091
"""1.1 kHz."""
DIO = ("DIO1", "DIO2", "DIO3", "DIO4")
ALARMS = 0x0300
CLOCK, DATA_READY, ALARM, OUTPUT, INPUT = range(5)


class Pins(dict[str, Net | None]):
    """The nets of the pins; the chip is told when one is put in."""

    def __init__(self, wired: Callable[[str, Net | None], None]) -> None:
        super().__init__(dict.fromkeys((*DIO, "RST")))
        self._wired = wired

    def __setitem__(self, pin: str, net: Net | None) -> None:
        old = self.get(pin)
        super().__setitem__(pin, net)
        self._wired(pin, old)


class PinSide:
    """Drives and follows the pins of one chip. `reset(held)` is called at the edges of RST."""

    def __init__(self, time: VirtualTime, core: Core, log: AccessLog, reset: Callable[[bool], None]) -> None:
        self.pins = Pins(self._wired)
        self._time = time
        self._core = core
        self._log = log
        self._reset = reset
        self._event: Event | None = None
        self._clock_net: Net | None = None
        self._last_edge_ns = -FAR
        self._pulse = False
        self._sample_ns = FAR
        self._driven: set[str] = set()

    def levels(self) -> int:
        """Bits 11 … 8 of GPIO_CTRL: what is at the pins that are inputs, of the others what was written."""
        driven = self._core.registers.values[reg.GPIO_CTRL + 1]
        for k, name in enumerate(DIO):
            net = self.pins[name]
            if net is not None and self._function(k) in (INPUT, CLOCK):
                driven = driven & ~(1 << k) | net.level << k
        return driven << 8

    # -- functions ---------------------------------------------------------------------------------

    def _function(self, k: int) -> int:
        values = self._core.registers.values
        if k == 3 and not values[reg.SMPL_PRD]:
            return CLOCK
        control, alarms = values[reg.MSC_CTRL], values[reg.ALM_CTRL]
        if control & 0x04 and control & 0x01 == k:
            return DATA_READY
        if alarms & 0x04 and alarms & 0x01 == k:
            return ALARM
        return OUTPUT if values[reg.GPIO_CTRL] >> k & 1 else INPUT

    def _alarm_level(self) -> bool:
        active = bool(self._core.diagnosis & ALARMS)
        return active == bool(self._core.registers.values[reg.ALM_CTRL] & 0x02)

    def _ready_level(self, active: bool) -> bool:
        return active == bool(self._core.registers.values[reg.MSC_CTRL] & 0x02)

    def drive(self) -> None:
        """Bring every output to its level; one that is an output no more falls."""
        values = self._core.registers.values
        for k, name in enumerate(DIO):
            net = self.pins[name]
            if net is None:
                continue
            function = self._function(k)
            if function in (INPUT, CLOCK):
                if name in self._driven:
                    self._driven.discard(name)
                    net.set(False)
                continue
            self._driven.add(name)
            if function == OUTPUT:
                net.set(bool(values[reg.GPIO_CTRL + 1] >> k & 1))
            elif function == ALARM:
                net.set(self._alarm_level())
            else:
                net.set(self._ready_level(self._pulse))

    # -- events ------------------------------------------------------------------------------------

    def schedule(self) -> None:
        """After settings, supply or sampling have changed: levels, the clock input, the next event."""
        if self._event is not None:
            self._event.cancel()
            self._event = None
        self._pulse = False
        self._follow_clock()
        self.drive()
        if self._followed():
            self._next()

    def _followed(self) -> bool:
        followed = False
        for k, name in enumerate(DIO):
            net = self.pins[name]
            if net is not None and self._function(k) in (DATA_READY, ALARM):
                net.on_first_listener = self._listener_arrived
                followed = followed or net.listened
        return followed

    def _listener_arrived(self) -> None:
        self._core.advance(self._time.now)
        self.schedule()

    def _next(self) -> None:
        due = self._expect()
        if due < FAR:
            self._event = self._time.at(max(due, self._time.now), self._happened)

    def _expect(self) -> int:
        """When the next thing comes. A read at that very instant may be served before the event."""
        self._sample_ns = self._core.sampler.next_ns
        return self._core.next_ns

    def _happened(self) -> int | None:
        """Event: a sample, the end of a command, or the end of a pulse."""
        now = self._time.now
        self._core.advance(now)
        self._pulse = self._sample_ns <= now
        due = self._expect()
        self.drive()
        if self._pulse:
            return now + PULSE_NS
        if due < FAR and self._followed():
            return max(now, due)
        self._event = None
        return None

    # -- inputs ------------------------------------------------------------------------------------

    def _follow_clock(self) -> None:
        net = self.pins["DIO4"] if self._function(3) == CLOCK else None
        if net is self._clock_net:
            return
        if self._clock_net is not None:
            self._clock_net.ignore_edges(self._clock_edge)
        self._clock_net = net
        if net is not None:
            net.listen_edge(True, self._clock_edge)

    def _clock_edge(self) -> None:
        now = self._time.now
        if now - self._last_edge_ns < SHORTEST_CLOCK_NS:
            detail = "external clock faster than 1.1 kHz: undefined, served"
            self._log.report(ReportKind.TIMING, "DIO4", detail, now)
        self._last_edge_ns = now
        self._core.external(now)
        if self._followed() and self._core.answers_ns <= now:
            if self._event is not None:
                self._event.cancel()
            self._pulse = True
            self.drive()
            self._event = self._time.at(now + PULSE_NS, self._happened)

    def _wired(self, pin: str, old: Net | None) -> None:
        if pin == "RST":
            if old is not None:
                old.ignore(self._reset_edge)
            net = self.pins[pin]
            if net is not None:
                net.listen(self._reset_edge)
        self.schedule()

    def _reset_edge(self, level: bool, _time_ns: int) -> None:
        self._reset(not level)
