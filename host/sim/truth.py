"""Truth as the scorer and the plots want it: batches of columns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TruthBatch:
    """Truth at n instants. Angles in rad (yaw 0 … 2π, pitch, roll), velocity in m/s, north-east-down."""

    times_ns: NDArray[np.int64]
    latitude: Array
    longitude: Array
    height: Array
    v_ned: Array
    """(n, 3)."""
    yaw: Array
    pitch: Array
    roll: Array
    bias_g: Array
    """(n, 3) rad/s, the gyro's whole additive error (turn-on, running, temperature) in the sensor's axes; NaN
    when it is not known or no sensor was asked for."""
    bias_a: Array
    """(n, 3) m/s², the accelerometer's."""


def unknown_bias(count: int) -> Array:
    """A bias that nobody knows."""
    return np.full((count, 3), math.nan)


def euler_angles(c_nb: Array) -> tuple[Array, Array, Array]:
    """Yaw, pitch, roll of matrices (n, 9), by rows."""
    yaw = np.arctan2(c_nb[:, 3], c_nb[:, 0]) % (2.0 * math.pi)
    pitch = np.arcsin(np.clip(-c_nb[:, 6], -1.0, 1.0))
    return yaw, pitch, np.arctan2(c_nb[:, 7], c_nb[:, 8])
