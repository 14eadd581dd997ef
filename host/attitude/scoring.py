"""Attitude errors as the BROAD data set defines them.

With q the estimate and r the reference, both sensor to east-north-up, e = q ⊗ r* is the error in the earth
frame, and of its parts e = (w, x, y, z)

    total 2 arccos |w|,     heading 2 arctan |z/w|,     inclination 2 arccos √(w² + z²).

Scored is the RMS over the samples with movement; those without a reference are left out. Nothing is fitted:
no offset of heading (the reference already points to magnetic north) and none of time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class AttitudeScore:
    """RMS errors in °."""

    total: float
    heading: float
    inclination: float


@dataclass(frozen=True, slots=True)
class AttitudeErrors:
    """Errors of every sample in °, (n,); NaN without a reference, or where the estimate is none."""

    total: Floats
    heading: Floats
    inclination: Floats
    has_reference: NDArray[np.bool_]

    def rms(self, scored: NDArray[np.bool_]) -> AttitudeScore:
        """Over the samples `scored` that have a reference; NaN when there is none, or one has no estimate."""
        used = scored & self.has_reference
        errors = (self.total, self.heading, self.inclination)
        return AttitudeScore(*(_rms(values[used]) for values in errors))


def product(a: Floats, b: Floats) -> Floats:
    """a ⊗ b of rows (w, x, y, z)."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        (
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ),
        axis=-1,
    )


def attitude_errors(estimate: Floats, reference: Floats) -> AttitudeErrors:
    """Of quaternions (n, 4), sensor to east-north-up, of length 1 or NaN."""
    estimate = estimate / np.linalg.norm(estimate, axis=1, keepdims=True)
    w, x, y, z = np.abs(product(estimate, reference * np.array([1.0, -1.0, -1.0, -1.0]))).T
    across, along = np.hypot(x, y), np.hypot(w, z)
    return AttitudeErrors(
        np.degrees(2.0 * np.arctan2(np.hypot(across, z), w)),
        np.degrees(2.0 * np.arctan2(z, w)),
        np.degrees(2.0 * np.arctan2(across, along)),
        np.asarray(np.isfinite(reference).all(axis=1), np.bool_),
    )


def east_north_up(q_nb: Floats) -> Floats:
    """(n, 4) quaternions to north-east-down turned into those to east-north-up."""
    half = np.sqrt(0.5)
    return product(np.array([0.0, half, half, 0.0]), q_nb)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values * values))) if len(values) else float("nan")
