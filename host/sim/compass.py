"""What a tilt-compensated compass feels on the vehicle: specific force and the Earth's magnetic field.

Field: the dipole of IGRF-13 (epoch 2020), with r the distance from the centre, a = 6371.2 km, θ the
geocentric colatitude, λ the longitude:

    B_r = 2 (a/r)³ (g₁₀ cos θ + q sin θ),      q = g₁₁ cos λ + h₁₁ sin λ
    B_θ =   (a/r)³ (g₁₀ sin θ − q cos θ),      B_λ = (a/r)³ (g₁₁ sin λ − h₁₁ cos λ)
    B_n = (−B_θ, B_λ, −B_r)

The real field differs from its dipole by some 10 % and by up to 20° of declination. Force: v̇ − g, where v̇ is
the change of velocity over 0.1 s, about what the part's own averaging leaves. Both in the chip's axes, with
white noise of the part's repeatability: 0.3° of heading, 0.2° of tilt.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import radii_and_gravity
from host.sim.seeding import generator
from host.sim.truth import TruthBatch

Array = NDArray[np.float64]

G10, G11, H11 = -29404.8e-9, -1450.9e-9, 4652.5e-9
"""T."""
REFERENCE_RADIUS = 6_371_200.0
HALF_SPAN_NS = 50_000_000
FIELD_NOISE_T = 1.0e-7
"""0.3° of a horizontal field of 200 mgauss."""
FORCE_NOISE = 0.034
"""m/s²: 0.2° of tilt."""
TEMPERATURE_C = 25.0


def dipole_field(latitude: float, longitude: float, height: float) -> tuple[float, float, float]:
    """North, east, down in T at a geodetic place (rad, m); geodetic latitude is taken for geocentric."""
    cube = (REFERENCE_RADIUS / (REFERENCE_RADIUS + height)) ** 3
    cos_theta, sin_theta = math.sin(latitude), math.cos(latitude)
    q = G11 * math.cos(longitude) + H11 * math.sin(longitude)
    radial = 2.0 * cube * (G10 * cos_theta + q * sin_theta)
    south = cube * (G10 * sin_theta - q * cos_theta)
    east = cube * (G11 * math.sin(longitude) - H11 * math.cos(longitude))
    return -south, east, -radial


class FeltCompass:
    """Implements `boards.chips.world.CompassWorld` on the truth of a drive."""

    def __init__(
        self,
        truth: Callable[[NDArray[np.int64]], TruthBatch],
        mounting: Array,
        seed: int,
        name: str,
    ) -> None:
        """`mounting` = C_b_s (3, 3): body = C_b_s sensor."""
        self._truth = truth
        self._c_sb = np.asarray(mounting, dtype=np.float64).T
        self._noise = generator(seed, f"{name}.compass.noise")

    def sample(self, times_ns: NDArray[np.int64]) -> Array:
        """Force (3), field (3), temperature at rising times."""
        values = np.empty((len(times_ns), 7))
        noise = self._noise.standard_normal((len(times_ns), 6))
        for row, when, normals in zip(values, times_ns.tolist(), noise, strict=True):
            row[:3], row[3:6] = self._felt(when)
            row[:3] += FORCE_NOISE * normals[:3]
            row[3:6] += FIELD_NOISE_T * normals[3:]
        values[:, 6] = TEMPERATURE_C
        return values

    def _felt(self, time_ns: int) -> tuple[Array, Array]:
        span = np.array([max(0, time_ns - HALF_SPAN_NS), time_ns + HALF_SPAN_NS], np.int64)
        around = self._truth(span)
        here = self._truth(np.array([time_ns], np.int64))
        place = float(here.latitude[0]), float(here.longitude[0]), float(here.height[0])
        _, _, gravity = radii_and_gravity(math.sin(place[0]), place[2])
        force_n = (around.v_ned[1] - around.v_ned[0]) / float(span[1] - span[0]) * 1e9
        force_n[2] -= gravity
        c_sn = self._c_sb @ _c_bn(float(here.yaw[0]), float(here.pitch[0]), float(here.roll[0]))
        return c_sn @ force_n, c_sn @ np.array(dipole_field(*place))


def _c_bn(yaw: float, pitch: float, roll: float) -> Array:
    """From north-east-down to forward-right-down."""
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    cr, sr = math.cos(roll), math.sin(roll)
    return np.array(
        [
            [cp * cy, cp * sy, -sp],
            [sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp],
            [cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp],
        ]
    )
