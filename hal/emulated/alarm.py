"""One event that moves: the next instant at which a peripheral has something to do."""

from __future__ import annotations

from collections.abc import Callable

from hal.emulated.virtual_time import FAR, Event, VirtualTime


class Alarm:
    """Calls `ring` at the instant set by `by`, or earlier.

    `ring` does what is due at now and answers the next instant (FAR: none), looked up last. Being called
    too early must do no harm: an instant that moves away leaves the event where it is. An instant that has
    passed counts as now.
    """

    __slots__ = ("_due", "_event", "_ring", "_time")

    def __init__(self, time: VirtualTime, ring: Callable[[], int]) -> None:
        self._time = time
        self._ring = ring
        self._due = FAR
        self._event: Event | None = None

    def by(self, time_ns: int) -> None:
        """Ring at `time_ns` or before."""
        if time_ns >= self._due:
            return
        if self._event is not None:
            self._event.cancel()
        self._due = max(time_ns, self._time.now)
        self._event = self._time.at(self._due, self._call)

    def _call(self) -> int | None:
        due = self._ring()
        if due >= FAR:
            self._due = FAR
            self._event = None
            return None
        self._due = max(due, self._time.now)
        return self._due
