"""The reference of a recorded drive as truth at any instant.

Positions are cubic Hermite curves through the poses and their velocities (20 Hz), velocities and quaternions
linear between them (the quaternion normalised): errors of millimetres for a car.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import ecef_to_geodetic
from host.sim.truth import TruthBatch, euler_angles, unknown_bias

Array = NDArray[np.float64]


class PoseReference:
    """Poses in ECEF on a time axis in virtual ns."""

    def __init__(self, times_ns: Array, position: Array, velocity: Array, q_eb: Array) -> None:
        """Position (n, 3) m, velocity (n, 3) m/s, both ECEF; q_eb (n, 4) scalar first."""
        self._times_ns = times_ns
        self._position = position
        self._velocity = velocity
        flips = np.cumprod(np.where(np.sum(q_eb[1:] * q_eb[:-1], axis=1) < 0.0, -1.0, 1.0))
        self._q_eb = q_eb * np.concatenate(([1.0], flips))[:, None]

    def truth(self, times_ns: NDArray[np.int64]) -> TruthBatch:
        """Truth of the device; instants outside the recording get the nearest pose."""
        t = np.clip(times_ns.astype(np.float64), self._times_ns[0], self._times_ns[-1])
        k = np.clip(np.searchsorted(self._times_ns, t, side="right") - 1, 0, len(self._times_ns) - 2)
        span = self._times_ns[k + 1] - self._times_ns[k]
        x = ((t - self._times_ns[k]) / span)[:, None]
        step = (span * 1e-9)[:, None]
        p0, p1 = self._position[k], self._position[k + 1]
        v0, v1 = self._velocity[k], self._velocity[k + 1]
        y = 1.0 - x
        ecef = p0 + x * x * (3.0 - 2.0 * x) * (p1 - p0) + step * x * y * (y * v0 - x * v1)
        q = self._q_eb[k] + x * (self._q_eb[k + 1] - self._q_eb[k])
        latitude, longitude, height = ecef_to_geodetic(ecef)
        c_ne = _ecef_to_ned(latitude, longitude)
        c_nb = c_ne @ _matrices(q / np.linalg.norm(q, axis=1, keepdims=True))
        yaw, pitch, roll = euler_angles(c_nb.reshape(-1, 9))
        v_ned = np.einsum("kij,kj->ki", c_ne, v0 + x * (v1 - v0))
        unknown = unknown_bias(len(times_ns))
        return TruthBatch(times_ns, latitude, longitude, height, v_ned, yaw, pitch, roll, unknown, unknown)


def _matrices(q: Array) -> Array:
    """Rotation matrices (n, 3, 3) of quaternions (n, 4)."""
    w, x, y, z = q.T
    rows = [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _ecef_to_ned(latitude: Array, longitude: Array) -> Array:
    sp, cp, sl, cl = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    zero = np.zeros_like(sp)
    rows = [[-sp * cl, -sp * sl, cp], [-sl, cl, zero], [-cp * cl, -cp * sl, -sp]]
    return np.moveaxis(np.array(rows), 2, 0)
