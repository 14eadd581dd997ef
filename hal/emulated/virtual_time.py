"""Virtual time: an integer count of nanoseconds and one queue of events.

Events at one time run by (time, priority, creation number). An event's callback must not let time pass:
it changes the state of hardware, raises interrupts and schedules further events. Time passes only in
`EmulatedCpu` (a processor at work or asleep), which takes due events off this queue.
"""

import heapq
from collections.abc import Callable
from typing import Any

SECOND = 1_000_000_000
FAR = 1 << 62
"""A time that is never reached (146 years)."""

Callback = Callable[[], int | None]


class Event:
    """A scheduled callback; `cancel` takes it back."""

    __slots__ = ("entry",)

    def __init__(self, entry: list[Any]) -> None:
        self.entry = entry

    def cancel(self) -> None:
        """Make sure that the callback does not run (again). Harmless when it has run."""
        self.entry[3] = None


class VirtualTime:
    """The clock and the event queue that everything emulated shares.

    `now` is the current time in nanoseconds since the start of the run, `next_due` the time of the
    earliest event.
    """

    __slots__ = ("_created", "_heap", "events_run", "horizon", "next_due", "now")

    def __init__(self) -> None:
        self.now = 0
        self.next_due = FAR
        self.horizon = FAR
        """While a further processor runs: the end of the first processor's work, not to be passed."""
        self.events_run = 0
        self._heap: list[list[Any]] = []
        self._created = 0

    def at(self, time_ns: int, callback: Callback, priority: int = 0) -> Event:
        """Run `callback` at `time_ns`.

        A callback that returns an integer runs again at that time, which is cheaper than a new event.
        Raises ValueError when the time has passed.
        """
        if time_ns < self.now:
            raise ValueError(f"event at {time_ns} ns lies before now ({self.now} ns); schedule at now or later")
        self._created += 1
        entry = [time_ns, priority, self._created, callback]
        heapq.heappush(self._heap, entry)
        if time_ns < self.next_due:
            self.next_due = time_ns
        return Event(entry)

    def run_next(self) -> None:
        """Move to the earliest event's time and run it. The queue must not be empty."""
        heap = self._heap
        entry = heap[0]
        callback = entry[3]
        if callback is not None:
            self.now = entry[0]
            self.events_run += 1
            again = callback()
            if again is not None and entry[3] is not None:
                self._repeat(entry, again)
                return
        if heap and heap[0] is entry:
            heapq.heappop(heap)
        elif entry[2] >= 0:
            self._remove(entry)
        self.next_due = heap[0][0] if heap else FAR

    def release_running(self) -> None:
        """Take the running event off the queue before its callback returns.

        For the one kind of callback that lets time pass: a switch to another processor.
        """
        entry = heapq.heappop(self._heap)
        entry[2] = -1
        self.next_due = self._heap[0][0] if self._heap else FAR

    def _repeat(self, entry: list[Any], time_ns: int) -> None:
        """Put a running event back at a later time."""
        heap = self._heap
        if time_ns < self.now:
            raise ValueError(f"event repeats at {time_ns} ns, before now ({self.now} ns)")
        self._created += 1
        if heap[0] is entry:
            entry[0] = time_ns
            entry[2] = self._created
            heapq.heapreplace(heap, entry)
        else:
            self._remove(entry)
            entry[0] = time_ns
            entry[2] = self._created
            heapq.heappush(heap, entry)
        self.next_due = heap[0][0]

    def _remove(self, entry: list[Any]) -> None:
        """Take a running event out although a more urgent one was put before it meanwhile."""
        self._heap.remove(entry)
        heapq.heapify(self._heap)


def instant(n: int, rate_hz: int, start_ns: int = 0) -> int:
    """Time of the n-th tick of a clock of `rate_hz`, computed from its count: t0 + n·10⁹ // f."""
    return start_ns + n * SECOND // rate_hz
