"""Independent watchdog. It stops with the reset that it causes; the firmware starts it again."""

from __future__ import annotations

from hal.emulated.alarm import Alarm
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.virtual_time import FAR


class EmulatedWatchdog:
    """Implements `hal.watchdog.Watchdog`. `bites`: how often it has reset the processor."""

    def __init__(self, cpu: EmulatedCpu) -> None:
        self.bites = 0
        self._cpu = cpu
        self._timeout_ns = 0
        self._deadline_ns = FAR
        self._alarm = Alarm(cpu.time, self._due)
        cpu.reset_hooks.append(self._reset)

    def start(self, timeout_ns: int) -> None:
        """Arm with this timeout; a second start changes it."""
        if timeout_ns <= 0:
            raise ValueError(f"watchdog timeout of {timeout_ns} ns; it must be positive, e.g. 1_000_000_000")
        self._timeout_ns = timeout_ns
        self._deadline_ns = self._cpu.time.now + timeout_ns
        self._alarm.by(self._deadline_ns)

    def kick(self) -> None:
        """Restart the timeout."""
        if self._deadline_ns < FAR:
            self._deadline_ns = self._cpu.time.now + self._timeout_ns

    def _due(self) -> int:
        if self._cpu.time.now < self._deadline_ns:
            return self._deadline_ns
        self.bites += 1
        self._deadline_ns = FAR
        self._cpu.reset("watchdog")
        return FAR

    def _reset(self) -> None:
        self._deadline_ns = FAR
