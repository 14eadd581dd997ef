"""What the FPGA collects in one position: whole numbers, from the accelerometers' counts and the compass.

rest   means of nine counts; is anything moving, the position is refused: a standard deviation beyond that
       of the chips, or two halves that differ
turn   ∫(count − mean at rest) dt, nine of them, averaged over the end of the time in which the table turns
       steadily: what the differences of them make of it is the rate that was gained
compass  heading, pitch, roll, horizontal field: means of a dozen readings
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins.accelerations import CHIPS
from firmware.drivers.adxl345_sample import SAMPLE_LENGTH

AXES: Final = 9
FRACTION: Final = 16
"""Bits behind the point."""
LARGEST_SIGMA: Final = 3.0
"""Counts of 1/256 g: the chips' own is about one."""
LARGEST_STEP: Final = 0.8
"""Counts between the halves of the time at rest."""
TICKS_PER_S: Final = 200
CHIP_OF_AXIS: Final = tuple(min(k, CHIPS - 1) for k in range(AXES))
BYTES: Final = np.array(
    [chip * SAMPLE_LENGTH + 1 + 2 * (k % 3) for k, chip in enumerate(CHIP_OF_AXIS)], np.int64
)
"""Of the low byte of A1 … A9 among the samples of all chips."""


def counts(raw: NDArray[np.uint8]) -> NDArray[np.int64]:
    """A1 … A9 as the chips have them."""
    words = raw[BYTES].astype(np.int64) | raw[BYTES + 1].astype(np.int64) << 8
    return (words ^ 0x8000) - 0x8000


class AtRest:
    """Means of nine."""

    def __init__(self, ticks: int) -> None:
        self.ticks = ticks
        self.taken = 0
        self._sums = np.zeros((2, AXES), np.int64)
        self._squares = np.zeros(AXES, np.int64)

    @property
    def is_done(self) -> bool:
        """Whether the time is over."""
        return self.taken >= self.ticks

    def take(self, now: NDArray[np.int64]) -> None:
        """Nine counts of a tick."""
        self._sums[int(2 * self.taken >= self.ticks)] += now
        self._squares += now * now
        self.taken += 1

    @property
    def means(self) -> NDArray[np.int64]:
        """Times 2^FRACTION."""
        return (self._sums.sum(axis=0) << FRACTION) // self.taken

    @property
    def has_moved(self) -> bool:
        """Whether it was no rest."""
        half = self.ticks // 2
        first, second = self._sums[0] / (self.ticks - half), self._sums[1] / half
        mean = self._sums.sum(axis=0) / self.taken
        sigma = np.sqrt(np.maximum(self._squares / self.taken - mean * mean, 0.0))
        return bool(np.any(sigma > LARGEST_SIGMA) or np.any(np.abs(second - first) > LARGEST_STEP))


class Turn:
    """What was gained since rest."""

    def __init__(self, rest: NDArray[np.int64], run_up_ticks: int, hold_ticks: int) -> None:
        self.ticks = run_up_ticks + hold_ticks
        self.taken = 0
        self._rest = rest
        self._run_up = run_up_ticks
        self._gained = np.zeros(AXES, np.int64)
        self._held = np.zeros(AXES, np.int64)

    @property
    def is_done(self) -> bool:
        """Whether the time is over."""
        return self.taken >= self.ticks

    def take(self, now: NDArray[np.int64]) -> None:
        """Nine counts of a tick."""
        self._gained += (now << FRACTION) - self._rest
        self.taken += 1
        if self.taken > self._run_up:
            self._held += self._gained

    @property
    def means(self) -> NDArray[np.int64]:
        """Count · s, times 2^FRACTION."""
        return self._held // (TICKS_PER_S * (self.taken - self._run_up))


class Readings:
    """A dozen readings of the compass: heading, pitch, roll in tenths of a degree, field x, y in counts."""

    def __init__(self, wanted: int) -> None:
        self.wanted = wanted
        self._rows: list[tuple[int, ...]] = []

    @property
    def is_done(self) -> bool:
        """Whether there are enough."""
        return len(self._rows) >= self.wanted

    @property
    def taken(self) -> int:
        """How many there are."""
        return len(self._rows)

    def take(self, row: tuple[int, ...]) -> None:
        """One more; the heading is counted on across north."""
        first = self._rows[0][0] if self._rows else row[0]
        turned = (row[0] - first + 1800) % 3600 - 1800
        self._rows.append((first + turned, *row[1:]))

    @property
    def means(self) -> list[int]:
        """Times 2^FRACTION."""
        return [(sum(column) << FRACTION) // len(self._rows) for column in zip(*self._rows, strict=True)]

    def spread(self, column: int) -> int:
        """Largest less smallest."""
        values = [row[column] for row in self._rows]
        return max(values) - min(values)
