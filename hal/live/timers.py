"""Hardware timers in real time: alarms of the processor, and the capture of a pin's edges."""

from __future__ import annotations

from time import monotonic_ns

from hal.interrupts import InterruptLine
from hal.live.alarms import Alarm
from hal.live.cpu import LiveCpu
from hal.live.pins import EdgeWatch, LevelSource
from hal.pins import Edge

SECOND = 1_000_000_000
CATCH_UP_NS = 1_000_000_000
"""Expiries that come later than this (the computer slept) are left out."""


class LiveTimer:
    """Implements `hal.timers.PeriodicTimer`.

    Expiries are computed from their number, so that a late one does not move the next. `left_out` counts
    those that came more than `CATCH_UP_NS` late and were not made up for.
    """

    def __init__(self, cpu: LiveCpu) -> None:
        self.left_out = 0
        self._cpu = cpu
        self._alarm: Alarm | None = None
        cpu.reset_hooks.append(self.stop)

    def start(self, rate_hz: int, line: InterruptLine) -> None:
        """First expiry one period from now. Raises ValueError for a rate that is not positive."""
        if rate_hz <= 0:
            raise ValueError(f"timer rate of {rate_hz} Hz; it must be positive, e.g. 100")
        self.stop()
        start_ns = monotonic_ns()
        count = 1

        def expire(due_ns: int) -> int:
            nonlocal count
            if monotonic_ns() - due_ns <= CATCH_UP_NS:
                line.pend()
            else:
                self.left_out += 1
            count += 1
            return start_ns + count * SECOND // rate_hz

        self._alarm = self._cpu.alarm_at(start_ns + SECOND // rate_hz, expire)

    def stop(self) -> None:
        """No more expiries."""
        if self._alarm is not None:
            self._alarm.cancel()
            self._alarm = None


class LiveCapture:
    """Implements `hal.timers.CaptureTimer` on a line that is looked at again and again.

    The clock is that of the look which found the edge, up to `period_ns` (and whatever the firmware did
    between two safe points) after it: good for a pulse a second, not for a precise one.
    """

    def __init__(
        self, cpu: LiveCpu, source: LevelSource, edge: Edge = Edge.RISING, period_ns: int = 1_000_000
    ) -> None:
        self._watch = EdgeWatch(cpu, source, period_ns)
        self._edge = edge
        self._edges = 0
        self._last_ns = 0
        cpu.reset_hooks.append(self._reset)

    def start(self, line: InterruptLine | None = None) -> None:
        """Capture from now on; pend `line`, when given, at every edge."""
        self._edges = self._last_ns = 0

        def latch(clock_ns: int) -> None:
            self._edges += 1
            self._last_ns = clock_ns
            if line is not None:
                line.pend()

        self._watch.begin(self._edge, latch)

    def captured(self) -> tuple[int, int]:
        """(edges since `start`, clock in nanoseconds at the last one)."""
        self._watch.look()
        return self._edges, self._last_ns

    def _reset(self) -> None:
        self._watch.end()
        self._edges = self._last_ns = 0
