"""The last seconds of a stream of rows, to look up values at instants between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LONGEST_STEP_S = 1.05
"""Rows further apart than this are not interpolated between: there is no solution in the gap."""

EDGE_S = 0.25
"""How far beyond the last row its values still hold."""


class RecentRows:
    """Rows (n, columns) with rising times; keeps what is younger than `span_s`."""

    def __init__(self, columns: int, span_s: float) -> None:
        self._span_s = span_s
        self._t = np.empty(0)
        self._rows = np.empty((0, columns))

    def __len__(self) -> int:
        return len(self._t)

    @property
    def newest(self) -> float:
        """Time of the last row; −∞ without rows."""
        return float(self._t[-1]) if len(self._t) else -np.inf

    def add(self, t: NDArray[np.float64], rows: NDArray[np.float64]) -> int:
        """Append rows and return how many were left out because their time does not rise."""
        before = np.maximum.accumulate(np.concatenate(([self.newest], t)))[:-1]
        rising = t > before
        self._t = np.concatenate((self._t, t[rising]))
        self._rows = np.concatenate((self._rows, rows[rising]))
        return len(t) - int(np.count_nonzero(rising))

    def forget_before(self, t: float) -> None:
        """Drop rows that are older than the span before `t`."""
        first = int(np.searchsorted(self._t, t - self._span_s))
        self._t = self._t[first:]
        self._rows = self._rows[first:]

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rows linearly interpolated at `times`, shape (n, columns); NaN where there is none near."""
        found = np.full((len(times), self._rows.shape[1]), np.nan)
        if len(self._t) == 0:
            return found
        last = len(self._t) - 1
        after = np.searchsorted(self._t, times - 1e-6)
        right = np.minimum(after, last)
        left = np.maximum(np.minimum(after - 1, last), 0)
        exact = np.abs(self._t[right] - times) <= 1e-6
        left = np.where(exact, right, left)
        gap = self._t[right] - self._t[left]
        share = np.where(gap > 0, (times - self._t[left]) / np.where(gap > 0, gap, 1.0), 0.0)
        inside = (
            (gap <= LONGEST_STEP_S) & (times >= self._t[left] - 1e-6) & (times <= self._t[right] + EDGE_S)
        )
        values = self._rows[left] + (self._rows[right] - self._rows[left]) * share[:, None]
        found[inside] = values[inside]
        return found
