"""Attitudes as yaw, pitch, roll, as quaternions and as matrices, many at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def quaternions(angles: Floats) -> Floats:
    """q_nb (n, 4), scalar first, of yaw, pitch, roll (n, 3) in rad; source 002, eq. 2-9 put right."""
    (cy, cp, cr), (sy, sp, sr) = np.cos(0.5 * angles).T, np.sin(0.5 * angles).T
    return np.column_stack(
        (
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        )
    )


def matrices(q: Floats) -> Floats:
    """C_n_b (n, 9), by rows, of quaternions (n, 4)."""
    a, b, c, d = q.T
    return np.column_stack(
        (
            *(a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c)),
            *(2.0 * (b * c + a * d), a * a - b * b + c * c - d * d, 2.0 * (c * d - a * b)),
            *(2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a - b * b - c * c + d * d),
        )
    )


def product(p: Floats, q: Floats) -> Floats:
    """p ⊗ q of quaternions (n, 4)."""
    a, b, c, d = p.T
    w, x, y, z = q.T
    return np.column_stack(
        (
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        )
    )
