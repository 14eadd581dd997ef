"""The time by which a chip is polled: that of the desk, or that of a record."""

from __future__ import annotations

from time import monotonic
from typing import Protocol

from hal.live.cpu import LiveCpu
from hal.scripted import Transcript


class Pace(Protocol):
    """A clock that one can wait on."""

    live: bool
    """Whether it is the real time, by which rates can be judged."""

    def now(self) -> float:
        """s."""
        ...

    def wait_until(self, time_s: float) -> None:
        """Let time pass."""
        ...

    def is_over(self) -> bool:
        """Whether there is nothing more to poll."""
        ...


class RealPace:
    """The desk goes on for ever."""

    live = True

    def __init__(self, cpu: LiveCpu) -> None:
        self._cpu = cpu

    def now(self) -> float:
        """By this computer's monotonic clock."""
        return monotonic()

    def wait_until(self, time_s: float) -> None:
        """Sleep."""
        self._cpu.delay(max(0, round((time_s - monotonic()) * 1e9)))

    def is_over(self) -> bool:
        """Never."""
        return False


class RecordedPace:
    """A record takes no time; every poll stands for its nominal period."""

    live = False

    def __init__(self, transcript: Transcript) -> None:
        self._transcript = transcript
        self._now = 0.0

    def now(self) -> float:
        """Nominal time since the record began."""
        return self._now

    def wait_until(self, time_s: float) -> None:
        """No waiting."""
        self._now = max(self._now, time_s)

    def is_over(self) -> bool:
        """At the end of the record."""
        return self._transcript.position >= len(self._transcript.steps)
