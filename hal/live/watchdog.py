"""Independent watchdog in real time.

It resets the firmware at its first safe point after the time-out. A program that hangs without touching
`hal` at all is not ended: nobody can take a thread off this computer's processor.
"""

from __future__ import annotations

from time import monotonic_ns

from hal.live.alarms import Alarm
from hal.live.cpu import LiveCpu


class LiveWatchdog:
    """Implements `hal.watchdog.Watchdog`. `bites`: how often it has reset the processor."""

    def __init__(self, cpu: LiveCpu) -> None:
        self.bites = 0
        self._cpu = cpu
        self._timeout_ns = 0
        self._deadline_ns = 0
        self._alarm: Alarm | None = None
        cpu.reset_hooks.append(self._reset)

    def start(self, timeout_ns: int) -> None:
        """Arm with this timeout; a second start changes it."""
        if timeout_ns <= 0:
            raise ValueError(f"watchdog timeout of {timeout_ns} ns; it must be positive, e.g. 1_000_000_000")
        self._timeout_ns = timeout_ns
        self._deadline_ns = monotonic_ns() + timeout_ns
        if self._alarm is not None:
            self._alarm.cancel()
        self._alarm = self._cpu.alarm_at(self._deadline_ns, self._due)

    def kick(self) -> None:
        """Restart the timeout. A kick that comes after it does not save the processor."""
        self._cpu.safe_point()
        if self._alarm is not None:
            self._deadline_ns = monotonic_ns() + self._timeout_ns

    def _due(self, _due_ns: int) -> int | None:
        if monotonic_ns() < self._deadline_ns:
            return self._deadline_ns
        self.bites += 1
        self._cpu.reset("watchdog")
        return None

    def _reset(self) -> None:
        self._alarm = None
