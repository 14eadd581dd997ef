"""What a sensor on a desk feels: gravity, a little tilt, a drift, noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.80665
FORCE = (0.4, -0.3, 9.79)
RATE = (0.01, -0.02, 0.005)
TEMPERATURE = 24.5


class Desk:
    """An ImuWorld that lies still; noise densities in m/s²/√Hz and rad/s/√Hz."""

    def __init__(self, force_noise: float = 0.002, rate_noise: float = 0.0001) -> None:
        self._noise = (force_noise, rate_noise)
        self._random = np.random.Generator(np.random.PCG64(7))

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> NDArray[np.float64]:
        values = np.tile((*FORCE, *RATE, TEMPERATURE), (len(times_ns), 1))
        for columns, density in zip((slice(0, 3), slice(3, 6)), self._noise, strict=True):
            values[:, columns] += (
                density * np.sqrt(bandwidth_hz) * self._random.standard_normal((len(times_ns), 3))
            )
        return values
