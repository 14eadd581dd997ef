"""A series that never grows beyond its bound: when it is full, every second row goes.

Rows are thinned evenly (every k-th is kept, k a power of two), so a plot shows the whole run at equal
spacing. What is kept depends only on the rows, not on how they were cut into batches.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


class DecimatedSeries:
    """Rows of equal length in bounded memory: between `limit` / 2 and `limit` rows once it has been full."""

    def __init__(self, columns: Sequence[str], limit: int = 4096) -> None:
        if limit < 2 or limit % 2:
            raise ValueError(f"limit is {limit}; an even number of at least 2 is needed, e.g. 4096")
        self.columns = tuple(columns)
        self.stride = 1
        self._rows = np.empty((limit, len(self.columns)))
        self._count = 0
        self._skip = 0

    def __len__(self) -> int:
        return self._count

    def add(self, rows: NDArray[np.float64]) -> None:
        """Append rows, shape (n, columns)."""
        while len(rows):
            wanted = rows[self._skip :: self.stride]
            room = len(self._rows) - self._count
            taken = wanted[:room]
            self._rows[self._count : self._count + len(taken)] = taken
            self._count += len(taken)
            if len(wanted) <= room:
                self._skip = (self._skip - len(rows)) % self.stride
            else:
                rows = rows[self._skip + room * self.stride :]
                self._skip = 0
                self._thin()
                continue
            return

    def _thin(self) -> None:
        """The buffer is full and the next row falls on the stride: keep every second row."""
        half = len(self._rows) // 2
        self._rows[:half] = self._rows[::2].copy()
        self._count = half
        self.stride *= 2

    def column(self, name: str) -> NDArray[np.float64]:
        """The kept values of one column."""
        return self._rows[: self._count, self.columns.index(name)].copy()
