"""How positions of something that stands scatter about their own mean, in metres north, east, down.

Nobody knows where the antenna truly is, so this is no error: it shows the noise and the wander of the time of
the attachment. What the receiver is off by all that time cannot be seen, and the solution, which leans on
the receiver, is off with it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from host.sim.earth import radians_per_metre

HALF_TURN = 180 * 10**9
MEANING = "about their own mean while standing; no error, since nobody knows where the antenna truly is"


class Scatter:
    """Running sums; positions in nanodegrees and m above the ellipsoid."""

    def __init__(self) -> None:
        self.count = 0
        self._origin: tuple[int, int, float] | None = None
        self._per_nanodeg = (0.0, 0.0)
        self._sum = np.zeros(3)
        self._squares = np.zeros(3)
        self._farthest = 0.0

    def add(self, lat_nanodeg: int, lon_nanodeg: int, height_m: float) -> None:
        """One position."""
        if self._origin is None:
            self._origin = (lat_nanodeg, lon_nanodeg, height_m)
            self._per_nanodeg = metres_per_nanodeg(lat_nanodeg, height_m)
        lat, lon, height = self._origin
        ned = np.array(
            (
                (lat_nanodeg - lat) * self._per_nanodeg[0],
                _around(lon_nanodeg - lon) * self._per_nanodeg[1],
                height - height_m,
            )
        )
        self.count += 1
        self._sum += ned
        self._squares += ned * ned
        self._farthest = max(self._farthest, math.hypot(ned[0], ned[1]))

    def figures(self) -> dict[str, Any]:
        """One sigma about the mean, and how far the farthest lies from the first."""
        if not self.count:
            return {"positions": 0}
        mean = self._sum / self.count
        sigma = np.sqrt(np.maximum(self._squares / self.count - mean * mean, 0.0))
        return {
            "positions": self.count,
            "sigma_north_m": float(sigma[0]),
            "sigma_east_m": float(sigma[1]),
            "sigma_down_m": float(sigma[2]),
            "farthest_from_first_m": self._farthest,
        }


def metres_per_nanodeg(lat_nanodeg: int, height_m: float) -> tuple[float, float]:
    """Of latitude, of longitude."""
    north, east = radians_per_metre(math.radians(lat_nanodeg * 1e-9), height_m)
    return math.radians(1e-9) / north, math.radians(1e-9) / east


def _around(lon_nanodeg: int) -> int:
    """A difference of longitudes, across the date line too."""
    return (lon_nanodeg + HALF_TURN) % (2 * HALF_TURN) - HALF_TURN
