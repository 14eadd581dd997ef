"""A hand that turns and shakes a sensor, in closed form as far as it goes; the attitude by fine integration.

Independent of the filter: quaternions here are multiplied in plain Python, rotations are scipy's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]
G = 9.80665
FIELD_NED = np.array([17.0, 0.0, 41.0])
"""µT, from magnetic north and down: a dip of 67°."""
FINE = 5


@dataclass(frozen=True)
class HandMotion:
    """Samples (n, 3) every `dt` and the true attitude sensor to north-east-down after each."""

    dt: float
    omega: Floats
    """Means over the interval before."""
    omega_now: Floats
    """At the sample's own time."""
    force: Floats
    field: Floats
    truth: Rotation
    moves: NDArray[np.bool_]

    def rows(self) -> Floats:
        """As `run_filter` wants them."""
        return np.column_stack((np.full(len(self.omega), self.dt), self.omega, self.force, self.field))

    def with_gyro(self, change: Floats) -> HandMotion:
        return replace(self, omega=self.omega + change, omega_now=self.omega_now + change)


def hand_motion(
    *,
    seed: int = 1,
    rate_hz: float = 200.0,
    rest_s: float = 6.0,
    moving_s: float = 34.0,
    turn: float = 2.0,
    shake: float = 2.0,
    calm_s: float = -1.0,
    first: Rotation | None = None,
) -> HandMotion:
    """`turn`: rad/s of each of four sines an axis, `shake`: m/s² of each of three.

    The last `calm_s` are calm.
    """
    rng = np.random.default_rng(seed)
    n = round((rest_s + moving_s) * rate_hz)
    dt = 1.0 / rate_hz
    fine = (np.arange(n * FINE) + 0.5) * dt / FINE
    end = rest_s + moving_s - calm_s
    gate = np.clip(np.minimum(fine - rest_s, end - fine) / 0.5, 0.0, 1.0)[:, None]
    rates = gate * sum(
        turn * rng.normal(size=3) * np.sin(2 * math.pi * rng.uniform(0.1, 0.7) * fine[:, None] + p)
        for p in rng.uniform(0, 6, (4, 3))
    )
    q = integrated(first or Rotation.from_rotvec([0.3, -0.2, 1.0]), rates, dt / FINE)
    truth = Rotation.from_quat(q[FINE - 1 :: FINE], scalar_first=True)
    t = (np.arange(n) + 1) * dt
    shaken = np.clip(np.minimum(t - rest_s, end - t) / 0.5, 0.0, 1.0)[:, None] * sum(
        shake * rng.normal(size=3) * np.sin(2 * math.pi * rng.uniform(0.5, 3.0) * t[:, None] + p)
        for p in rng.uniform(0, 6, (3, 3))
    )
    noise = rng.normal(0.0, 0.002, (n, 3))
    return HandMotion(
        dt,
        rates.reshape(n, FINE, 3).mean(axis=1) + noise,
        1.5 * rates[FINE - 1 :: FINE] - 0.5 * rates[FINE - 2 :: FINE] + noise,
        truth.inv().apply(shaken - [0.0, 0.0, G]) + rng.normal(0.0, 0.02, (n, 3)),
        truth.inv().apply(np.tile(FIELD_NED, (n, 1))) + rng.normal(0.0, 0.3, (n, 3)),
        truth,
        t > rest_s,
    )


def integrated(first: Rotation, rates: Floats, dt: float) -> Floats:
    """Quaternions (n, 4), scalar first, after each of the constant rates (n, 3)."""
    w, x, y, z = first.as_quat(scalar_first=True)
    angle = np.linalg.norm(rates, axis=1) * dt
    c, s = np.cos(angle / 2), 0.5 * dt * np.sinc(angle / (2 * math.pi))
    found = []
    for cw, (cx, cy, cz) in zip(c.tolist(), (rates * s[:, None]).tolist(), strict=True):
        w, x, y, z = (
            w * cw - x * cx - y * cy - z * cz,
            w * cx + x * cw + y * cz - z * cy,
            w * cy - x * cz + y * cw + z * cx,
            w * cz + x * cy - y * cx + z * cw,
        )
        found.append((w, x, y, z))
    return np.array(found)


def errors_deg(estimate: Floats, motion: HandMotion) -> Floats:
    """Total rotation error of q_nb (n, 4) after each sample."""
    return np.degrees((Rotation.from_quat(estimate, scalar_first=True) * motion.truth.inv()).magnitude())


def rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
