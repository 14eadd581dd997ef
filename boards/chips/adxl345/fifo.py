"""Data registers and FIFO: what is unread (fact sheet section 5).

32 samples wait in the FIFO and one more behind it at the output of the filter, so that 33 can be read; the
entries shown are never more than 32. In bypass mode only the newest sample counts.

Reading any data register takes a sample out. That is complete 5 µs after the end of the read; before that
the chip still shows the sample that was read, and counts it.
"""

from __future__ import annotations

from collections import deque
from typing import Final

from boards.chips.adxl345.register_map import FIFO_TRIG
from boards.chips.adxl345.sampler import Sampler

BYPASS: Final = 0
FIFO: Final = 1
STREAM: Final = 2
TRIGGER: Final = 3
"""FIFO_MODE."""

ENTRIES: Final = 32
CAPACITY: Final = ENTRIES + 1
POP_NS: Final = 5_000


class Fifo:
    """The samples that nobody has read yet."""

    __slots__ = ("_queue", "_taken", "mode", "overrun", "samples", "settled_ns", "triggered", "unread")

    def __init__(self) -> None:
        self._queue: deque[bytes] = deque()
        self.reset()

    def reset(self) -> None:
        """As after power-on."""
        self._queue.clear()
        self.mode = BYPASS
        self.samples = 0
        """What FIFO_CTL holds as samples."""
        self.triggered = False
        self.unread = 0
        """In bypass mode: 0, 1, or 2 for several."""
        self.overrun = False
        self._taken: bytes | None = None
        """The sample read last; shown while there is no other."""
        self.settled_ns = 0
        """When the last read is complete."""

    # -- set-up ------------------------------------------------------------------------------------

    def control(self, fifo_ctl: int, newest: bytes) -> None:
        """FIFO_CTL was written. `newest` is what the data registers hold in bypass mode."""
        mode = fifo_ctl >> 6
        self.samples = fifo_ctl & 0x1F
        if mode == self.mode:
            return
        if mode == BYPASS:
            self._queue.clear()
            self.triggered = False
        if BYPASS in (mode, self.mode):
            self.unread = 0
            self.overrun = False
            self._taken = newest
        self.mode = mode

    @property
    def armed(self) -> bool:
        """In trigger mode and still waiting."""
        return self.mode == TRIGGER and not self.triggered

    # -- samples come --------------------------------------------------------------------------------

    def take(self, sampler: Sampler, after: int, count: int) -> None:
        """`count` output samples came after the tick `after`."""
        if count <= 0:
            return
        if self.mode == BYPASS:
            self.unread = min(self.unread + count, 2)
            self.overrun = self.unread > 1
            return
        assert sampler.plan is not None
        period = sampler.plan.period
        first = (after // period + 1) * period
        queue = self._queue
        if count == 1 and len(queue) < ENTRIES - 1:
            queue.append(sampler.registers(first))
            return
        if self.mode == STREAM or self.armed:
            skipped = max(0, count - CAPACITY)
            wanted = range(skipped, count)
        else:
            wanted = range(min(count, CAPACITY - len(queue)))
        for k in wanted:
            queue.append(sampler.registers(first + k * period))
        while len(queue) > CAPACITY:
            queue.popleft()
        self.overrun = self.overrun or len(queue) >= ENTRIES

    def trigger(self) -> None:
        """The trigger pin: keep the newest samples and go on as in FIFO mode."""
        self.triggered = True
        while len(self._queue) > self.samples:
            self._queue.popleft()

    # -- what it shows -------------------------------------------------------------------------------

    @property
    def data_ready(self) -> bool:
        """Whether there is anything unread."""
        return bool(self.unread if self.mode == BYPASS else self._queue)

    @property
    def watermark(self) -> bool:
        """Whether as many entries wait as FIFO_CTL tells."""
        return min(len(self._queue), ENTRIES) >= self.samples

    def samples_to_change(self, data_ready: bool, watermark: bool, overrun: bool) -> int:
        """Samples until one of the wanted flags comes up at the earliest; 0 when none can."""
        waiting = self.unread if self.mode == BYPASS else len(self._queue)
        counts = []
        if data_ready and not self.data_ready:
            counts.append(1)
        if watermark and not self.watermark and self.mode != BYPASS:
            counts.append(self.samples - waiting)
        if overrun and not self.overrun:
            counts.append(max(1, (2 if self.mode == BYPASS else ENTRIES) - waiting))
        return min(counts, default=0)

    def settling(self, time_ns: int) -> bool:
        """Whether the last read is not complete yet."""
        return time_ns < self.settled_ns

    def status(self, time_ns: int) -> int:
        """FIFO_STATUS."""
        return self.status_of(len(self._queue) + self.settling(time_ns))

    def status_of(self, waiting: int) -> int:
        """FIFO_STATUS with so many samples."""
        return (FIFO_TRIG if self.triggered else 0) | min(waiting, ENTRIES)

    # -- reading -------------------------------------------------------------------------------------

    def shown(self, newest: bytes, time_ns: int) -> bytes:
        """A zero and the data registers at a time."""
        if self.mode == BYPASS:
            return newest
        if self._queue and not self.settling(time_ns):
            return self._queue[0]
        return self._taken if self._taken is not None else newest

    def read(self, time_ns: int, end_ns: int, *, settles: bool) -> None:
        """Data registers were read from `time_ns` to `end_ns`; `settles`: completing it takes its time."""
        self.overrun = False
        if self.mode == BYPASS:
            self.unread = 0
            return
        if not self.settling(time_ns):
            if not self._queue:
                return
            self._taken = self._queue.popleft()
        if settles:
            self.settled_ns = end_ns + POP_NS

    # -- worked out elsewhere ------------------------------------------------------------------------

    def waiting(self) -> list[bytes]:
        """The samples that wait, the oldest first."""
        return list(self._queue)

    def resume(self, waiting: list[bytes], taken: bytes | None, settled_ns: int) -> None:
        """Go on with these, `taken` being the sample that was read last meanwhile; None: none was."""
        self._queue = deque(waiting)
        if taken is not None:
            self.overrun = False
            self._taken = taken
            self.settled_ns = settled_ns
