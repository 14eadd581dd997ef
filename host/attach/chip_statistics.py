"""Running figures of a sensor's samples: mean, extremes, noise.

Noise is the standard deviation of the difference of neighbouring samples over √2: white noise comes out
with its σ, slow motion and a drifting bias do not count.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class SampleStatistics:
    """Of samples of `size` values."""

    def __init__(self, size: int) -> None:
        self.count = 0
        self.last = np.zeros(size)
        self.mean = np.zeros(size)
        self.lowest = np.full(size, np.inf)
        self.highest = np.full(size, -np.inf)
        self._squares = np.zeros(size)
        self._differences = 0

    def add(self, sample: NDArray[np.float32], follows: bool) -> None:
        """One sample; `follows`: it is the next one after the last."""
        value = sample.astype(np.float64)
        if self.count and follows:
            self._squares += (value - self.last) ** 2
            self._differences += 1
        self.count += 1
        self.mean += (value - self.mean) / self.count
        np.minimum(self.lowest, value, out=self.lowest)
        np.maximum(self.highest, value, out=self.highest)
        self.last = value

    @property
    def noise(self) -> NDArray[np.float64]:
        """1 σ of each value; NaN before the second sample."""
        if not self._differences:
            return np.full(len(self.mean), np.nan)
        return np.sqrt(self._squares / (2.0 * self._differences))
