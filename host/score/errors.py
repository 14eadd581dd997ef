"""Errors of a solution against the truth, and the sign conventions of all figures.

Every error is *estimated minus true*:

- position in m north, east, down: (φ̂ − φ)(M + h), (λ̂ − λ)(N + h) cos φ, −(ĥ − h), with the meridian and
  transverse radii M and N of the WGS-84 ellipsoid at the true latitude;
- velocity in m/s north, east, down;
- attitude as the rotation vector ψ in n with  Ĉ_n_b = exp([ψ×]) C_n_b,  that is ψ = log(Ĉ_n_b C_n_bᵀ);
- roll, pitch and yaw as differences of the Z-Y-X Euler angles, wrapped into (−π, π].

The Euler differences are what people read (`roll_rms_deg` …); the rotation vector is what the normalised
error (NEES) and the σ bands use, because a filter's attitude covariance belongs to it.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from host.record.run_data import MotionBatch, SolutionBatch

Floats = NDArray[np.float64]

SEMI_MAJOR_AXIS = 6378137.0
ECCENTRICITY_SQUARED = (2 - 1 / 298.257223563) / 298.257223563

POSITION_AND_VELOCITY = ("north", "east", "down", "v_north", "v_east", "v_down")
COLUMNS = (*POSITION_AND_VELOCITY, "psi_n", "psi_e", "psi_d", "roll", "pitch", "yaw")
"""Columns of `solution_errors`: m, m/s, rad."""


class Place(Protocol):
    """Positions in radians and m above the ellipsoid, arrays of one length."""

    @property
    def latitude(self) -> Floats:
        """Geodetic latitude, rad."""
        ...

    @property
    def longitude(self) -> Floats:
        """Longitude, rad."""
        ...

    @property
    def height(self) -> Floats:
        """Height above the ellipsoid, m."""
        ...


def wrapped(angle: Floats) -> Floats:
    """`angle` (rad) plus a whole number of turns, in (−π, π]."""
    return np.pi - np.mod(np.pi - angle, 2 * np.pi)


def position_error_ned(estimate: Place, truth: Place) -> Floats:
    """Estimated minus true position, m north, east, down, shape (n, 3). For errors small beside the Earth."""
    sine = np.sin(truth.latitude)
    w2 = 1 - ECCENTRICITY_SQUARED * sine * sine
    transverse = SEMI_MAJOR_AXIS / np.sqrt(w2)
    meridian = transverse * (1 - ECCENTRICITY_SQUARED) / w2
    error = np.empty((len(truth.latitude), 3))
    error[:, 0] = (estimate.latitude - truth.latitude) * (meridian + truth.height)
    error[:, 1] = wrapped(estimate.longitude - truth.longitude)
    error[:, 1] *= (transverse + truth.height) * np.cos(truth.latitude)
    error[:, 2] = truth.height - estimate.height
    return error


def quaternions(yaw: Floats, pitch: Floats, roll: Floats) -> Floats:
    """q_nb (scalar first, Hamilton) of Z-Y-X Euler angles, shape (n, 4)."""
    sy, cy = np.sin(yaw / 2), np.cos(yaw / 2)
    sp, cp = np.sin(pitch / 2), np.cos(pitch / 2)
    sr, cr = np.sin(roll / 2), np.cos(roll / 2)
    q = np.empty((len(yaw), 4))
    q[:, 0] = cr * cp * cy + sr * sp * sy
    q[:, 1] = sr * cp * cy - cr * sp * sy
    q[:, 2] = cr * sp * cy + sr * cp * sy
    q[:, 3] = cr * cp * sy - sr * sp * cy
    return q


def product(p: Floats, q: Floats) -> Floats:
    """p ⊗ q for each row, shape (n, 4)."""
    result = np.empty(np.broadcast_shapes(p.shape, q.shape))
    p0, p1, p2, p3 = np.moveaxis(p, -1, 0)
    q0, q1, q2, q3 = np.moveaxis(q, -1, 0)
    result[..., 0] = p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3
    result[..., 1] = p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2
    result[..., 2] = p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1
    result[..., 3] = p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0
    return result


def conjugate(q: Floats) -> Floats:
    """The inverse rotation of unit quaternions, shape (n, 4)."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def rotation_vectors(q: Floats) -> Floats:
    """Rotation vector (rad) of each unit quaternion, shape (n, 3), no longer than π."""
    vector = q[:, 1:] * np.where(q[:, :1] < 0, -1.0, 1.0)
    sine = np.sqrt(np.sum(vector * vector, axis=1))
    angle = 2 * np.arctan2(sine, np.abs(q[:, 0]))
    factor = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)
    return np.asarray(vector * factor[:, None])


def attitude_error(estimate: Floats, truth: Floats) -> Floats:
    """ψ in n of estimated against true q_nb, both (n, 4); shape (n, 3)."""
    return rotation_vectors(product(estimate, conjugate(truth)))


def solution_errors(solution: SolutionBatch, truth: MotionBatch) -> Floats:
    """All errors of a batch, shape (n, 12), columns as in COLUMNS."""
    errors = np.empty((len(solution), len(COLUMNS)))
    errors[:, 0:3] = position_error_ned(solution, truth)
    errors[:, 3:6] = solution.velocity_ned - truth.velocity_ned
    estimated = quaternions(solution.yaw, solution.pitch, solution.roll)
    errors[:, 6:9] = attitude_error(estimated, quaternions(truth.yaw, truth.pitch, truth.roll))
    errors[:, 9] = wrapped(solution.roll - truth.roll)
    errors[:, 10] = solution.pitch - truth.pitch
    errors[:, 11] = wrapped(solution.yaw - truth.yaw)
    return errors
