"""The FIFO worked out from times alone, while nothing but output samples changes it.

Samples of a block lie one behind the other, and those that wait are the newest of them: two counts, of the
samples that have come and of those that were read, tell all that FIFO_STATUS and the data registers show.
The FIFO itself (`Fifo`) is brought up to date when the lane closes: before any other access, at the end of
the block, and before it overflows.
"""

from __future__ import annotations

from typing import Final

from boards.chips.adxl345.core import Core
from boards.chips.adxl345.fifo import BYPASS, ENTRIES, POP_NS
from boards.chips.adxl345.sample_kernels import STRIDE

MOST_WAITING: Final = ENTRIES - 1
"""One more sets the overrun flag."""


class FifoLane:
    """One chip's. Closed, it answers nothing."""

    __slots__ = (
        "_answers",
        "_begun",
        "_come",
        "_core",
        "_image",
        "_next_ns",
        "_read",
        "_settled_ns",
        "_times",
        "_to_ns",
    )

    def __init__(self, core: Core) -> None:
        self._core = core
        self._to_ns = 0
        """It serves accesses before that; 0: closed."""
        self._next_ns = 0
        """When the next sample comes."""
        self._settled_ns = 0
        """When the last read is complete."""
        self._come = self._read = self._begun = 0
        """Rows of the block that have come, of those that were read, and of those when it opened."""
        self._times: list[int] = []
        self._image = b""
        self._answers: list[bytes] = []
        """To FIFO_STATUS, by the number of samples that wait."""

    def open(self) -> None:
        """Take over from the FIFO as it is, if it holds just the newest samples of the block."""
        core = self._core
        fifo, sampler = core.fifo, core.sampler
        if fifo.mode == BYPASS or not core.steady or not sampler.times:
            return
        come = sampler.row_of(core.tick) + 1
        waiting = fifo.waiting()
        read = come - len(waiting)
        if read < 0 or come >= len(sampler.times) or len(waiting) > MOST_WAITING:
            return
        image = sampler.image
        if b"".join(waiting) != image[read * STRIDE : come * STRIDE]:
            return
        self._times, self._image = sampler.times, image
        self._come, self._read, self._begun = come, read, read
        self._next_ns = self._times[come]
        self._settled_ns = fifo.settled_ns
        self._answers = [bytes((0, fifo.status_of(count))) for count in range(MOST_WAITING + 1)]
        self._to_ns = self._times[-1]

    def drop(self) -> None:
        """Close it; the FIFO is lost."""
        self._to_ns = 0

    def close(self) -> None:
        """Give back to the FIFO and to the core what has come and what was read."""
        if not self._to_ns:
            return
        self._to_ns = 0
        core = self._core
        image, read, come = self._image, self._read, self._come
        waiting = [image[row * STRIDE : (row + 1) * STRIDE] for row in range(read, come)]
        taken = image[(read - 1) * STRIDE : read * STRIDE] if read > self._begun else None
        core.fifo.resume(waiting, taken, self._settled_ns)
        core.resume(come - 1)

    def status(self, time_ns: int) -> bytes | None:
        """Answer to a read of FIFO_STATUS; None: there is more to it."""
        if (
            time_ns >= self._to_ns
            or time_ns < self._settled_ns
            or (time_ns >= self._next_ns and not self._count(time_ns))
        ):
            return None
        return self._answers[self._come - self._read]

    def pop(self, time_ns: int, end_ns: int) -> bytes | None:
        """A burst of the data registers up to `end_ns` takes out a sample; None: there is more to it."""
        if (
            time_ns >= self._to_ns
            or time_ns < self._settled_ns
            or (time_ns >= self._next_ns and not self._count(time_ns))
        ):
            return None
        read = self._read
        if read >= self._come:
            return None
        self._read = read + 1
        self._settled_ns = end_ns + POP_NS
        return self._image[read * STRIDE : (read + 1) * STRIDE]

    def _count(self, time_ns: int) -> bool:
        """Samples up to a time before `_to_ns`; False, and nothing is changed, if they are too many."""
        times, come, next_ns = self._times, self._come, self._next_ns
        last = self._read + MOST_WAITING
        while next_ns <= time_ns:
            come += 1
            if come > last:
                return False
            next_ns = times[come]
        self._come = come
        self._next_ns = next_ns
        return True
