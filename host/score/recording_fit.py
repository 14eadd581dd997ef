"""Scores of a recording with and without one constant time shift and one constant body-frame offset.

The reference of a real recording belongs to another point of the vehicle (a camera) and to another clock.
Both show as errors of whoever is compared with it. So the figures are also told after fitting, once for the
fused solution and once for the receiver alone, the constants τ and d in

    e_k = v_k τ + C_n_b,k d + residual,    e_k = estimated minus true position, NED

by linear least squares over all scored epochs (v, C_n_b: true velocity and attitude; all three axes weigh
the same). A positive τ says that the estimate is where the reference will be τ later. The model is linear
in τ: an acceleration of 3 m/s² and τ = 0.1 s leave 1.5 cm. Where the velocity hardly changes in the body
frame, τ and the forward offset cannot be told apart: `condition` is then large, and the sum alone is known.

Attitude: the constant rotation between the two body frames, q_off = mean of q_nb* ⊗ q̂_nb, is removed:
q̂ ⊗ q_off*. It is told as roll, pitch and yaw of the estimated body seen from the reference body.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.score.errors import conjugate, product, rotation_vectors

Floats = NDArray[np.float64]

LIMIT = 36_000
"""Epochs that are kept; a longer recording is fitted on its first part."""

POSITION_FIGURES = tuple(
    f"{when}_position_{kind}_rms_m" for when in ("before", "after") for kind in ("horizontal", "vertical")
)
FIGURES = (
    "epochs",
    *(
        f"{who}.{name}"
        for who in ("fused", "gnss")
        for name in ("time_shift_s", "condition", *POSITION_FIGURES)
    ),
    *(f"attitude.after_{axis}_rms_deg" for axis in ("roll", "pitch", "yaw")),
)
"""Figures of `RecordingFit.result`, by dotted names."""

DEGREES = 180 / np.pi
AXES = ("roll", "pitch", "yaw")


class RecordingFit:
    """Collects scored epochs of a recording and fits the constants at the end."""

    def __init__(self) -> None:
        self._rows: list[Floats] = []
        self._count = 0

    def add(self, fused: Floats, receiver: Floats, velocity: Floats, q_nb: Floats) -> None:
        """Fused errors (n, 12), receiver errors (n, 6), true velocity (n, 3) and attitude (n, 4)."""
        take = min(len(fused), LIMIT - self._count)
        self._rows.append(np.concatenate((fused, receiver, velocity, q_nb), axis=1)[:take])
        self._count += take

    def result(self) -> dict[str, Any]:
        """`epochs`, `fused`, `gnss` (each: constants found, figures before and after) and `attitude`."""
        if self._count < 4:
            return {"epochs": self._count}
        rows = np.concatenate(self._rows)
        velocity, q_nb = rows[:, 18:21], rows[:, 21:25]
        return {
            "epochs": self._count,
            "fused": fit_shift_and_offset(rows[:, 0:3], velocity, q_nb),
            "gnss": fit_shift_and_offset(rows[:, 12:15], velocity, q_nb),
            "attitude": fit_mounting(rows[:, 6:9], q_nb),
        }


def fit_shift_and_offset(errors: Floats, velocity: Floats, q_nb: Floats) -> dict[str, Any]:
    """Fit τ and d to position errors (n, 3); the figures tell RMS before and after."""
    design = np.empty((len(errors), 3, 4))
    design[:, :, 0] = velocity
    design[:, :, 1:] = rotation_matrices(q_nb)
    solved, _, _, singular = np.linalg.lstsq(design.reshape(-1, 4), errors.reshape(-1), rcond=None)
    residual = errors - design @ solved
    return {
        "time_shift_s": float(solved[0]),
        "offset_frd_m": [float(value) for value in solved[1:]],
        "condition": float(singular[0] / singular[-1]) if singular[-1] > 0 else None,
        **_position_figures("before_", errors),
        **_position_figures("after_", residual),
    }


def _position_figures(prefix: str, errors: Floats) -> dict[str, float]:
    squares = np.mean(errors * errors, axis=0)
    return {
        f"{prefix}position_horizontal_rms_m": float(np.sqrt(squares[0] + squares[1])),
        f"{prefix}position_vertical_rms_m": float(np.sqrt(squares[2])),
    }


def rotation_matrices(q: Floats) -> Floats:
    """C_n_b of unit quaternions q_nb (n, 4), shape (n, 3, 3)."""
    w, x, y, z = q.T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def fit_mounting(psi: Floats, q_nb: Floats) -> dict[str, Any]:
    """Remove the constant mounting rotation from attitude errors ψ (n, 3); degrees, about the body axes."""
    angle = np.sqrt(np.sum(psi * psi, axis=1, keepdims=True))
    half_sinc = np.sinc(angle / (2 * np.pi)) / 2
    error = np.concatenate((np.cos(angle / 2), psi * half_sinc), axis=1)
    relative = product(product(conjugate(q_nb), error), q_nb)
    relative *= np.where(relative[:, :1] < 0, -1.0, 1.0)
    offset = relative.mean(axis=0)
    offset /= np.sqrt(np.sum(offset * offset))
    residual = rotation_vectors(product(relative, conjugate(offset)))
    figures = dict(zip(AXES, np.sqrt(np.mean(residual * residual, axis=0)) * DEGREES, strict=True))
    return {
        "mounting_deg": dict(zip(AXES, _euler_degrees(offset), strict=True)),
        **{f"after_{axis}_rms_deg": float(value) for axis, value in figures.items()},
    }


def _euler_degrees(q: Floats) -> list[float]:
    w, x, y, z = q.tolist()
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return [float(angle * DEGREES) for angle in (roll, pitch, yaw)]
