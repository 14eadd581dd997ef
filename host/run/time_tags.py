"""How well the board dated the receiver's epochs, and what that does to position."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


class TimeTags:
    """Running sums over epochs: tagged minus true validity, and the way travelled in that time."""

    def __init__(self) -> None:
        self._count = 0
        self._sum_s = 0.0
        self._squares_s2 = 0.0
        self._way_squares_m2 = 0.0

    def add(self, error_ns: NDArray[np.int64], velocity_ned: NDArray[np.float64]) -> None:
        """Errors of some epochs (n,) and the true velocity (n, 3) at their validity."""
        error = error_ns / 1e9
        way = error * np.linalg.norm(velocity_ned[:, :2], axis=1)
        self._count += len(error)
        self._sum_s += float(error.sum())
        self._squares_s2 += float((error * error).sum())
        self._way_squares_m2 += float((way * way).sum())

    def figures(self) -> dict[str, float | None]:
        """Mean and RMS of the error in s, RMS of its effect on horizontal position in m."""
        n = self._count
        return {
            "time_tag_error_mean_s": self._sum_s / n if n else None,
            "time_tag_error_rms_s": math.sqrt(self._squares_s2 / n) if n else None,
            "time_tag_position_effect_rms_m": math.sqrt(self._way_squares_m2 / n) if n else None,
        }
