"""What every fault has: a beginning, an end, and a count of how often it struck."""

from __future__ import annotations

from collections.abc import Callable

from hal.emulated.virtual_time import FAR, VirtualTime


class Fault:
    """Base of all faults."""

    def __init__(self, start_ns: int, end_ns: int = FAR) -> None:
        if not 0 <= start_ns < end_ns:
            raise ValueError(
                f"fault from {start_ns} ns to {end_ns} ns; it must start at 0 or later and then end"
            )
        self.start_ns = start_ns
        self.end_ns = end_ns
        self.fired = 0
        self._at_work: bool | None = None
        """None: not yet; False: it has passed."""
        self._end: Callable[[], None] = _nothing

    def lift(self) -> None:
        """End it now, or see to it that it does not begin. Harmless when it has passed."""
        end = self._end if self._at_work else _nothing
        self._at_work = False
        end()

    def _schedule(self, time: VirtualTime, begin: Callable[[], None], end: Callable[[], None]) -> None:
        if self.end_ns <= time.now:
            raise ValueError(f"fault ends at {self.end_ns} ns, which has passed (now {time.now} ns)")
        self._end = end
        if self.start_ns <= time.now:
            self._begin(begin)
        else:
            time.at(self.start_ns, lambda: self._begin(begin))
        if self.end_ns < FAR:
            time.at(self.end_ns, self.lift)

    def _begin(self, begin: Callable[[], None]) -> None:
        if self._at_work is None:
            self._at_work = True
            begin()


def _nothing() -> None:
    pass
