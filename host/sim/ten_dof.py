"""What a sensor of rate, force, magnetic field and pressure feels: an inertial sensor and more columns.

Field: the dipole of `host.sim.compass`. Pressure: the standard atmosphere of ISO 2533 below 11 km,

    p = 101325 Pa · (1 − 2.25577·10⁻⁵ h)^5.25588,      h: height above the ellipsoid, taken for the altitude

Errors as the ADIS16407's sheet has them: 0.066 mgauss/√Hz and a bias of 4 mgauss (1 σ of one draw an axis)
of the magnetometers, 0.027 mbar of the barometer.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import ImuWorld
from host.sim.compass import G10, G11, H11, REFERENCE_RADIUS
from host.sim.seeding import generator
from host.sim.truth import TruthBatch

Array = NDArray[np.float64]

FIELD_DENSITY = 0.066e-7
"""T/√Hz."""
FIELD_BIAS_T = 4.0e-7
PRESSURE_NOISE_PA = 2.7
SEA_LEVEL_PA, LAPSE, EXPONENT = 101_325.0, 2.25577e-5, 5.25588


class FeltTenDof:
    """Implements `boards.chips.world.TenDofWorld` on an inertial sensor and the truth of a drive."""

    def __init__(
        self,
        imu: ImuWorld,
        truth: Callable[[NDArray[np.int64]], TruthBatch],
        mounting: Array,
        seed: int,
        name: str,
        *,
        perfect: bool = False,
    ) -> None:
        """`mounting` = C_b_s (3, 3): body = C_b_s sensor. `perfect`: no errors of field and pressure."""
        self._imu = imu
        self._truth = truth
        self._c_bs = np.asarray(mounting, dtype=np.float64)
        self._noise = generator(seed, f"{name}.ten_dof.noise")
        self._gain = 0.0 if perfect else 1.0
        self._bias = self._gain * FIELD_BIAS_T * generator(seed, f"{name}.ten_dof.bias").standard_normal(3)

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> Array:
        """Force (3), rate (3), temperature, field (3), pressure at rising times."""
        truth = self._truth(times_ns)
        noise = self._gain * self._noise.standard_normal((len(times_ns), 4))
        values = np.empty((len(times_ns), 11))
        values[:, :7] = self._imu.sample(times_ns, bandwidth_hz)
        values[:, 7:10] = field_in_body(truth) @ self._c_bs
        values[:, 7:10] += self._bias + FIELD_DENSITY * math.sqrt(bandwidth_hz) * noise[:, :3]
        values[:, 10] = standard_pressure(truth.height) + PRESSURE_NOISE_PA * noise[:, 3]
        return values


def standard_pressure(height: Array) -> Array:
    """Pa at heights in m."""
    below = np.clip(1.0 - LAPSE * height, 0.0, None)
    return np.asarray(SEA_LEVEL_PA * below**EXPONENT, np.float64)


def field_in_body(truth: TruthBatch) -> Array:
    """The dipole's field (n, 3) in T, forward, right, down."""
    cube = (REFERENCE_RADIUS / (REFERENCE_RADIUS + truth.height)) ** 3
    cos_theta, sin_theta = np.sin(truth.latitude), np.cos(truth.latitude)
    q = G11 * np.cos(truth.longitude) + H11 * np.sin(truth.longitude)
    north = -cube * (G10 * sin_theta - q * cos_theta)
    east = cube * (G11 * np.sin(truth.longitude) - H11 * np.cos(truth.longitude))
    down = -2.0 * cube * (G10 * cos_theta + q * sin_theta)
    cy, sy = np.cos(truth.yaw), np.sin(truth.yaw)
    cp, sp = np.cos(truth.pitch), np.sin(truth.pitch)
    cr, sr = np.cos(truth.roll), np.sin(truth.roll)
    ahead, aside = cy * north + sy * east, cy * east - sy * north
    lifted = sp * ahead + cp * down
    return np.column_stack((cp * ahead - sp * down, cr * aside + sr * lifted, cr * lifted - sr * aside))
