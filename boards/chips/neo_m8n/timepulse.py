"""The time pulse output (fact sheet section 1; CFG-TP5).

As it comes: 1 Hz, 100 ms high, rising edge on the top of the second of GPS time, only while there is a
fix. The pulse is predicted from the last epoch: it starts one period after the first fix and stops after
the first epoch without. Edges lie exactly on the receiver's idea of time plus the user's delay; the
delays of antenna cable and receiver are compensated in a real installation and therefore not simulated.

A pin that nobody listens to stays at its resting level and costs no event.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct

from boards.chips.receivers.utc import SECOND
from hal.emulated.pins import Net
from hal.emulated.virtual_time import Event, VirtualTime

LAYOUT = Struct("<BBHhh4IiI")
"""tpIdx, version, reserved, cable and RF delay ns, period or frequency, the same when locked, length or
ratio, the same when locked, user delay ns, flags."""
ACTIVE = 0x01
LOCKED_OTHER_SET = 0x04
IS_FREQUENCY = 0x08
IS_LENGTH = 0x10
RISING_AT_TOP = 0x40
GRID_SHIFT, GRID_MASK, GRID_UTC = 7, 0x0F, 0
SHORTEST_PERIOD_NS = 1_000_000
BEFORE_EPOCH = -1
"""Event priority: the pulse of a second comes before what the receiver computes for it."""


@dataclass(frozen=True, slots=True)
class Pulse:
    """Period and length of the active part, ns."""

    period_ns: int
    length_ns: int


@dataclass(frozen=True, slots=True)
class TimePulseSettings:
    """CFG-TP5 decoded. `unlocked` and `locked` are what to put out without and with a fix."""

    active: bool
    unlocked: Pulse
    locked: Pulse
    delay_ns: int
    active_high: bool
    utc_grid: bool


def decode(payload: bytes) -> TimePulseSettings:
    """Settings from a CFG-TP5 payload."""
    _, _, _, _, _, rate, rate_locked, width, width_locked, delay, flags = LAYOUT.unpack(payload)
    unlocked = _pulse(rate, width, flags)
    return TimePulseSettings(
        active=bool(flags & ACTIVE),
        unlocked=unlocked,
        locked=_pulse(rate_locked, width_locked, flags) if flags & LOCKED_OTHER_SET else unlocked,
        delay_ns=delay,
        active_high=bool(flags & RISING_AT_TOP),
        utc_grid=(flags >> GRID_SHIFT & GRID_MASK) == GRID_UTC,
    )


def _pulse(rate: int, width: int, flags: int) -> Pulse:
    period = (SECOND // rate if rate else 0) if flags & IS_FREQUENCY else rate * 1000
    length = width * 1000 if flags & IS_LENGTH else period * width >> 32
    return Pulse(period, length)


class TimePulse:
    """Drives the net in step with the receiver's time."""

    def __init__(self, time: VirtualTime) -> None:
        self.net: Net | None = None
        self.settings: TimePulseSettings | None = None
        self._time = time
        self._reference_ns = 0
        self._locked = False
        self._next: Event | None = None
        self._fall: Event | None = None

    def configure(self, settings: TimePulseSettings) -> None:
        """Take new settings; the running pulse is broken off."""
        if settings != self.settings:
            self.stop(level=settings.active and not settings.active_high)
            self.settings = settings

    def follow(self, gps_time_ns: int, leap_seconds: int, locked: bool) -> None:
        """An epoch was computed now: `gps_time_ns` is its time, `locked` whether it has a fix."""
        settings = self.settings
        if settings is None:
            return
        leap_ns = leap_seconds * SECOND if settings.utc_grid else 0
        reference_ns = gps_time_ns - leap_ns - self._time.now
        if reference_ns != self._reference_ns and self._next is not None:
            self._next.cancel()
            self._next = None
        self._reference_ns = reference_ns
        self._locked = locked
        if self._next is None and self.net is not None and self.net.listened and self._pulse() is not None:
            if self._fall is None:
                self._rest()
            self._next = self._time.at(self._next_top(), self._rise, BEFORE_EPOCH)

    def stop(self, level: bool = False) -> None:
        """No further pulse; the net goes to `level`."""
        for event in (self._next, self._fall):
            if event is not None:
                event.cancel()
        self._next = self._fall = None
        self._locked = False
        if self.net is not None:
            self.net.set(level)

    def _pulse(self) -> Pulse | None:
        """What to put out now, if anything."""
        settings = self.settings
        if settings is None or not settings.active:
            return None
        pulse = settings.locked if self._locked else settings.unlocked
        return pulse if pulse.length_ns > 0 and pulse.period_ns > 0 else None

    def _next_top(self) -> int:
        """Virtual time of the next active edge after now."""
        pulse, settings, now = self._pulse(), self.settings, self._time.now
        assert pulse is not None
        assert settings is not None
        shifted = now + self._reference_ns - settings.delay_ns
        return now + pulse.period_ns - shifted % pulse.period_ns

    def _rise(self) -> int | None:
        pulse, settings, net = self._pulse(), self.settings, self.net
        if pulse is None or settings is None or net is None or not net.listened:
            self._next = None
            return None
        net.set(settings.active_high)
        self._fall = self._time.at(self._time.now + pulse.length_ns, self._end, BEFORE_EPOCH)
        return self._next_top()

    def _end(self) -> None:
        self._fall = None
        self._rest()

    def _rest(self) -> None:
        if self.net is not None and self.settings is not None:
            self.net.set(not self.settings.active_high)
