"""What a live processor does at given times: the expiries of its timers, the looks at its pins."""

from __future__ import annotations

from collections.abc import Callable
from heapq import heappop, heappush

AlarmCallback = Callable[[int], int | None]
"""Gets the time it was due at (ns of the monotonic clock), returns when it is due again or None."""


class Alarm:
    """A callback and when it is due next."""

    __slots__ = ("callback", "due_ns")

    def __init__(self, due_ns: int, callback: AlarmCallback) -> None:
        self.due_ns = due_ns
        self.callback: AlarmCallback | None = callback

    def cancel(self) -> None:
        """Make sure that the callback does not run (again). Harmless when it has run."""
        self.callback = None


class Alarms:
    """Alarms by the time they are due. Used by the firmware's thread alone."""

    def __init__(self) -> None:
        self._heap: list[tuple[int, int, Alarm]] = []
        self._created = 0

    def at(self, due_ns: int, callback: AlarmCallback) -> Alarm:
        """Call `callback` at `due_ns`, or as soon after it as the firmware comes to a safe point."""
        alarm = Alarm(due_ns, callback)
        self._push(alarm)
        return alarm

    def clear(self) -> None:
        """Cancel all."""
        for _, _, alarm in self._heap:
            alarm.cancel()
        self._heap.clear()

    @property
    def next_due_ns(self) -> int | None:
        """When the earliest alarm is due."""
        heap = self._heap
        while heap and heap[0][2].callback is None:
            heappop(heap)
        return heap[0][0] if heap else None

    def run_next(self) -> None:
        """Run the earliest alarm. There must be one (`next_due_ns` tells)."""
        alarm = heappop(self._heap)[2]
        if alarm.callback is None:
            return
        again = alarm.callback(alarm.due_ns)
        if again is not None and alarm.callback is not None:
            alarm.due_ns = again
            self._push(alarm)

    def _push(self, alarm: Alarm) -> None:
        self._created += 1
        heappush(self._heap, (alarm.due_ns, self._created, alarm))
