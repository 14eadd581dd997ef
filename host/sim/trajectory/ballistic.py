"""Free flight of a shell over a level ground, as pieces of speed and pitch.

    v_x = v₀ cos θ₀,   v_up = v₀ sin θ₀ − g t,   v = √(v_x² + v_up²),   θ = atan(v_up / v_x)

Neither is a polynomial: each stretch of `STRETCH_S` is the polynomial of degree 7 that has their values and
first three derivatives at both ends, so that jerk is continuous; it errs by less than 1e-9 m/s and rad.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from host.sim.trajectory.piece import Piece

GRAVITY = 9.80665
STRETCH_S = 0.25
"""At 100 m/s; the motion is slower in proportion to speed."""

Floats = NDArray[np.float64]


def flight_time(speed: float, elevation: float) -> float:
    """Until it is back at its height, s."""
    return 2.0 * speed * math.sin(elevation) / GRAVITY


def flight(speed: float, elevation: float, duration_s: float) -> tuple[list[Piece], list[Piece]]:
    """(acceleration along the path, pitch against the elevation) from the muzzle on."""
    count = max(1, math.ceil(duration_s / (STRETCH_S * min(1.0, max(speed, 1.0) / 100.0))))
    times = np.linspace(0.0, duration_s, count + 1)
    speeds, angles = _motion(speed, elevation, times)
    step = duration_s / count
    along, pitch = [], []
    for k in range(count):
        v = _hermite(step, speeds[:, k], speeds[:, k + 1])
        along.append(Piece(step, tuple((i + 1) * float(v[i + 1]) for i in range(7))))
        p = _hermite(step, angles[:, k], angles[:, k + 1])
        p[0] -= elevation
        pitch.append(Piece(step, tuple(p.tolist())))
    return along, pitch


def _motion(speed: float, elevation: float, t: Floats) -> tuple[Floats, Floats]:
    """Speed and path angle with three derivatives each, (4, n)."""
    x, up = speed * math.cos(elevation), speed * math.sin(elevation) - GRAVITY * t
    square = x * x + up * up
    v = np.sqrt(square)
    a = -GRAVITY * up / v
    jerk = (GRAVITY * GRAVITY - a * a) / v
    snap = -3.0 * a * jerk / v
    rate = -GRAVITY * x / square
    square1, square2 = -2.0 * GRAVITY * up, 2.0 * GRAVITY * GRAVITY
    rate1 = -rate * square1 / square
    rate2 = -(2.0 * rate1 * square1 + rate * square2) / square
    return np.stack((v, a, jerk, snap)), np.stack((np.arctan2(up, np.full_like(up, x)), rate, rate1, rate2))


def _hermite(step: float, start: Floats, end: Floats) -> Floats:
    """Coefficients of the polynomial of degree 7 with these values and derivatives at 0 and `step`."""
    powers = np.arange(8)
    rows = []
    for at in (0.0, 1.0):
        for order in range(4):
            factor = np.array([math.perm(k, order) for k in powers], dtype=np.float64)
            rows.append(
                [f * (at ** (k - order) if k >= order else 0.0) for k, f in zip(powers, factor, strict=True)]
            )
    scale = step ** np.arange(4)
    unit: Floats = np.linalg.solve(np.array(rows), np.concatenate((start * scale, end * scale)))
    return unit / step**powers
