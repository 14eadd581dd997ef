"""A recorded inertial sensor, interpolated at the instants at which a chip model samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TEMPERATURE_C = 25.0
"""The recording has none."""


class RecordedImu:
    """Implements `boards.chips.world.ImuWorld`. Errors and noise are those of the recorded sensor."""

    def __init__(self, times_ns: Array, force: Array, rate: Array, mounting: Array) -> None:
        """`times_ns` of the recorded samples in virtual time; force and rate (n, 3) in body axes."""
        self._times_ns = times_ns
        self._columns = [
            np.ascontiguousarray(column) for column in np.hstack((force @ mounting, rate @ mounting)).T
        ]

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> Array:
        """Linear between the recorded samples, constant before the first and after the last.

        The recorded sensor has its own bandwidth; `bandwidth_hz` changes nothing.
        """
        out = np.empty((len(times_ns), 7))
        for i, column in enumerate(self._columns):
            out[:, i] = np.interp(times_ns, self._times_ns, column)
        out[:, 6] = TEMPERATURE_C
        return out
