"""Virtual time: an integer count of nanoseconds and one queue of events.

Events at one time run by (time, priority, creation number). An event's callback must not let time pass:
it changes the state of hardware, raises interrupts and schedules further events. Time passes only in
`EmulatedCpu` (a processor at work or asleep), which takes due events off this queue.
"""

from collections.abc import Callable
from heapq import heapify, heappop, heappush, heapreplace
from typing import Any, Final, SupportsIndex

from hal.emulated.whole_number import whole_number

SECOND: Final = 1_000_000_000
FAR: Final = (1 << 62) - 1
"""A time that is never reached (146 years), and the largest integer that machine code keeps in a register."""

RELEASED: Final = -1
SENTINELS: Final = 3

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

    __slots__ = (
        "_created",
        "_dropped",
        "_horizon",
        "heap",
        "limit",
        "next_due",
        "now",
        "repeated",
        "second_due",
    )

    def __init__(self) -> None:
        self.now = 0
        self.next_due = FAR
        self.limit = FAR
        """Work that ends before this needs no look at the queue: `next_due`, or the end of the first
        processor's own work while a further processor runs."""
        self.second_due = FAR
        """No event but the first one is due before that: what repeats before it stays first."""
        self._horizon = FAR
        # Entries that are never reached: the queue is never empty, and its first entry has two below it.
        self.heap: list[list[Any]] = [[FAR, 0, 0, _nothing] for _ in range(SENTINELS)]
        """[time, priority, creation number, callback] of every event; also for the idle processor."""
        self.repeated = 0
        """Events that stayed first when they repeated. They keep their creation number, since
        no other event has their time."""
        self._created = 0
        self._dropped = 0
        """Events that were cancelled before they ran."""

    @property
    def events_run(self) -> int:
        """How many callbacks have run (and returned)."""
        return self.repeated + self._created - self._dropped - (len(self.heap) - SENTINELS)

    def at(self, time_ns: SupportsIndex, callback: Callback, priority: int = 0) -> Event:
        """Run `callback` at `time_ns`.

        A callback that returns an integer runs again at that time, which is cheaper than a new event.
        Raises ValueError when the time has passed.
        """
        due = time_ns if isinstance(time_ns, int) else whole_number(time_ns, "time of an event in ns")
        if due < self.now:
            raise ValueError(f"event at {due} ns lies before now ({self.now} ns); schedule at now or later")
        self._created += 1
        entry = [due, priority, self._created, callback]
        heappush(self.heap, entry)
        if due < self.next_due:
            self.second_due = self.next_due
            self._set_due(due)
        elif due < self.second_due:
            self.second_due = due
        return Event(entry)

    def look_now(self) -> None:
        """Make every processor look for interrupts before it lets more time pass, by an empty event.

        For a request outside an event: firmware drives a pin that is wired to another processor's
        interrupt, or reads a chip that changes its interrupt pin. Needed only while `next_due` > `now`.
        """
        self.at(self.now, _nothing)

    def _set_due(self, time_ns: int) -> None:
        self.next_due = time_ns
        self.limit = time_ns if time_ns < self._horizon else self._horizon

    def run_next_before(self, end_ns: int) -> None:
        """`run_next` for a processor whose own work ends at `end_ns`: no other processor may pass that."""
        self._horizon = end_ns
        self.run_next()
        self._horizon = FAR

    def run_next(self) -> None:
        """Move to the earliest event's time and run it. There must be one.

        What repeats before all others come needs no sorting: it stays at the head of the heap.
        """
        heap = self.heap
        entry = heap[0]
        callback = entry[3]
        if callback is None:
            self.drop_first()
            return
        self.now = now = entry[0]
        again: object = callback()
        if isinstance(again, int) and now <= again < self.second_due:
            entry[0] = self.next_due = self.limit = again
            self.repeated += 1
        else:
            self.put_away(entry, again)

    def drop_first(self) -> None:
        """Take out the earliest event, which was cancelled."""
        heappop(self.heap)
        self._dropped += 1
        self.next_due = self.limit = self.heap[0][0]
        self._find_second()

    def put_away(self, entry: list[Any], answer: Any) -> None:
        """Take out the event that has run, or put it where it belongs now."""
        heap = self.heap
        if answer is None or isinstance(answer, int):
            again: int | None = answer
        else:
            again = whole_number(answer, "time at which an event repeats in ns")
        if again is not None and heap[0] is entry and again >= self.now:
            entry[0] = again
            self._created = entry[2] = self._created + 1
            heapreplace(heap, entry)
        else:
            self._put_away_from_within(entry, again)
        self.next_due = self.limit = heap[0][0]
        self._find_second()

    def _find_second(self) -> None:
        """After the order of events has changed."""
        heap = self.heap
        one, other = heap[1][0], heap[2][0]
        self.second_due = one if one < other else other

    def _put_away_from_within(self, entry: list[Any], again: int | None) -> None:
        """The same of an event that is over, was released or has a more urgent one before it by now."""
        if again is not None and again < self.now:
            raise ValueError(f"event repeats at {again} ns, before now ({self.now} ns)")
        if entry[2] == RELEASED:
            return
        self._take_out(entry)
        if again is not None:
            self._created += 1
            entry[0], entry[2] = again, self._created
            heappush(self.heap, entry)

    def _take_out(self, entry: list[Any]) -> None:
        """Also when a more urgent one stands before it by now."""
        if self.heap[0] is entry:
            heappop(self.heap)
        else:
            self.heap.remove(entry)
            heapify(self.heap)

    def release_running(self) -> None:
        """Take the running event off the queue before its callback returns.

        For the one kind of callback that lets time pass: a switch to another processor.
        """
        entry = heappop(self.heap)
        entry[2] = RELEASED
        self._set_due(self.heap[0][0])
        self._find_second()


def instant(n: int, rate_hz: int, start_ns: int = 0) -> int:
    """Time of the n-th tick of a clock of `rate_hz`, computed from its count: t0 + n·10⁹ // f."""
    return start_ns + n * SECOND // rate_hz


def _nothing() -> None:
    """Event that only brings its instant about."""
