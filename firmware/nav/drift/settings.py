"""What a user of the drift compensation may set, and its way into the arrays."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.drift import bias, heading
from firmware.nav.drift import layout as at

SATURATED_SHARE = 0.998
"""Rates of this share of the range are taken for its end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriftSettings:
    """All in rad and s. ValueError for what cannot be."""

    rate_range: float | None = None
    """Largest rate that the gyros can tell, rad/s; None: any."""
    declination: float = 0.0
    """Of the magnetic field, east positive; 0 gives headings from magnetic north."""
    gyro_delay: float = 0.0
    """By how much rates are older than the time they are told for: a chip's filter. The attitude is
    predicted ahead for it with the last rate."""

    def __post_init__(self) -> None:
        if self.rate_range is not None and not 0.1 <= self.rate_range <= 200.0:
            raise ValueError(
                f"rate_range is {self.rate_range} rad/s; it lies in 0.1 … 200, e.g. 5.236 (300 °/s)"
            )
        if not abs(self.declination) <= math.pi:
            raise ValueError(f"declination is {self.declination} rad; it lies in −π … π, e.g. 0.05")
        if not 0.0 <= self.gyro_delay <= 0.1:
            raise ValueError(f"gyro_delay is {self.gyro_delay} s; it lies in 0 … 0.1, e.g. 0.003")


def new_state(
    settings: DriftSettings | None = None, dtype: Any = np.float32
) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Arrays (d, k) before the first sample. `dtype`: np.float64 for the float64 variant."""
    settings = settings or DriftSettings()
    d: NDArray[Any] = np.zeros(at.D_SIZE, dtype)
    k = np.zeros(at.K_SIZE, np.int64)
    d[at.Q_NB] = d[at.Q_FREE] = d[at.Q_LEVEL] = 1.0
    d[[bias.XX, bias.YY, bias.ZZ]] = bias.FIRST_VARIANCE
    d[at.REJECTED_TIME] = 2.0 * heading.LONGEST_REJECTION
    d[at.CANDIDATE_NORM] = -1.0
    d[at.HEADING_VARIANCE] = heading.LARGEST_VARIANCE
    d[at.RATE_LIMIT] = 0.0 if settings.rate_range is None else SATURATED_SHARE * settings.rate_range
    d[at.DECLINATION] = settings.declination
    d[at.GYRO_DELAY] = settings.gyro_delay
    return d, k
