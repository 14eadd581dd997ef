"""How far measured angles are from true ones: wrapped per angle, and as one rotation.

ε = 2 arccos |q̂ · q|    computed as 2 arctan2(|v|, |w|) of q̂* ∘ q, which keeps small angles exact
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def wrapped(angle: Array) -> Array:
    """Angles in rad, within ±π."""
    return np.asarray(angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)), np.float64)


def quaternion(angles: Array) -> Array:
    """q_nb (n, 4), scalar first, of (n, 3) pitch, roll, yaw in rad."""
    pitch, roll, yaw = (0.5 * angles[:, k] for k in range(3))
    cp, sp, cr, sr, cy, sy = (
        np.cos(pitch),
        np.sin(pitch),
        np.cos(roll),
        np.sin(roll),
        np.cos(yaw),
        np.sin(yaw),
    )
    return np.column_stack(
        (
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        )
    )


def rotation_between(one: Array, other: Array) -> Array:
    """Total rotation (n,) in rad between two attitudes of (n, 3) pitch, roll, yaw."""
    return rotation_between_quaternions(quaternion(one), quaternion(other))


def rotation_between_quaternions(a: Array, b: Array) -> Array:
    """Total rotation (n,) in rad between unit quaternions (n, 4)."""
    w = np.sum(a * b, axis=1)
    vector = a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - np.cross(a[:, 1:], b[:, 1:])
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(vector, axis=1), np.abs(w)), np.float64)
