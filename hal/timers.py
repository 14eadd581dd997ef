"""Hardware timers: a periodic interrupt and an input capture."""

from typing import Protocol

from hal.interrupts import InterruptLine


class PeriodicTimer(Protocol):
    """Pends its line at an exact rate of the processor's crystal."""

    def start(self, rate_hz: int, line: InterruptLine) -> None:
        """First expiry one period from now, the n-th at n / rate_hz, without accumulated rounding."""
        ...

    def stop(self) -> None:
        """No more expiries."""
        ...


class CaptureTimer(Protocol):
    """Latches the processor's clock at an edge of its input pin."""

    def start(self, line: InterruptLine | None = None) -> None:
        """Capture from now on; pend `line`, when given, at every edge."""
        ...

    def captured(self) -> tuple[int, int]:
        """(edges since `start`, clock in nanoseconds at the last one); (0, 0) before the first."""
        ...
