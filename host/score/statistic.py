"""Mean, RMS, maximum and quantiles of a stream of non-negative values in fixed memory.

Mean and RMS come from running sums in double precision and are exact to rounding. Quantiles come from a
histogram with bins of equal ratio (2^(1/128), from 2^-20 to 2^30): a quantile is told as the middle of
its bin, so it is within 0.28 % of the exact one (nearest-rank definition) for values inside that range.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

BINS_PER_OCTAVE = 128
LOWEST_OCTAVE = -20
OCTAVES = 50


class Statistic:
    """A stream of values >= 0. Values that are not finite are counted apart and else left out."""

    def __init__(self) -> None:
        self.count = 0
        self.not_finite = 0
        self.maximum = 0.0
        self._sum = 0.0
        self._sum_of_squares = 0.0
        self._bins = np.zeros(OCTAVES * BINS_PER_OCTAVE, dtype=np.int64)

    def add(self, values: NDArray[np.float64]) -> None:
        """Take in values, shape (n,)."""
        good = values[np.isfinite(values)]
        self.not_finite += len(values) - len(good)
        if len(good) == 0:
            return
        self.count += len(good)
        self.maximum = max(self.maximum, float(good.max()))
        self._sum += float(good.sum())
        self._sum_of_squares += float((good * good).sum())
        octave = np.log2(np.maximum(good, 2.0**LOWEST_OCTAVE)) - LOWEST_OCTAVE
        places = np.minimum((octave * BINS_PER_OCTAVE).astype(np.int64), len(self._bins) - 1)
        np.add.at(self._bins, places, 1)

    def mean(self) -> float | None:
        """Arithmetic mean; None without values."""
        return self._sum / self.count if self.count else None

    def rms(self) -> float | None:
        """Root of the mean square; None without values."""
        return math.sqrt(self._sum_of_squares / self.count) if self.count else None

    def max(self) -> float | None:
        """Largest value; None without values."""
        return self.maximum if self.count else None

    def quantile(self, share: float) -> float | None:
        """The value that `share` (0 … 1] of all values do not exceed, within 0.28 %; None without values."""
        if self.count == 0:
            return None
        rank = max(1, math.ceil(share * self.count - 1e-9))
        place = int(np.searchsorted(np.cumsum(self._bins), rank))
        middle = 2.0 ** ((place + 0.5) / BINS_PER_OCTAVE + LOWEST_OCTAVE)
        return min(middle, self.maximum)
