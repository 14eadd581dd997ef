"""The road of a capture, out of its decoded topics: true motion where it is known, and receiver epochs.

Truth is the recorded solution minus its recorded error. Where a capture knows no truth, the recorded solution
itself takes its place. Between rows: positions as cubic Hermite curves through places and velocities,
velocities and angles linear.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.record.run_data import NAVIGATING
from host.sim.earth import E2, SEMI_MAJOR
from host.sim.truth import TruthBatch, unknown_bias

Array = NDArray[np.float64]
NS = 1_000_000_000
AGAINST_TRUTH, AGAINST_SOLUTION, AGAINST_RECEIVER = (
    "truth",
    "recorded solution",
    "recorded receiver, attitude against its course",
)
LONGEST_STEP_S = 2.0
"""Rows further apart than this are not interpolated between."""
POSITION, VELOCITY = (
    ("latitude_deg", "longitude_deg", "height_m"),
    ("v_north_mps", "v_east_mps", "v_down_mps"),
)
ANGLES = ("yaw_deg", "pitch_deg", "roll_deg")
_ERRORS = (
    *("error_north_m", "error_east_m", "error_down_m"),
    *("error_v_north_mps", "error_v_east_mps", "error_v_down_mps"),
    *("error_yaw_deg", "error_pitch_deg", "error_roll_deg"),
)
MOTION_COLUMNS = ("mode", *POSITION, *VELOCITY, *ANGLES)
ROAD_COLUMNS = (*MOTION_COLUMNS, *_ERRORS)
"""What a road needs of rows of solutions, besides their times."""


class Road:
    """Motion of the navigation point from rows of /solution, or of a table with the same columns."""

    def __init__(self, rows: Sequence[Mapping[str, Any]], known_from: str | None = None) -> None:
        """`known_from`: what the rows are, when they are no solutions."""
        navigating = [row for row in rows if row["mode"] is not None and row["mode"] >= NAVIGATING]
        known = [row for row in navigating if row["error_north_m"] is not None]
        self.known_from = known_from or (AGAINST_TRUTH if known else AGAINST_SOLUTION)
        """Whose motion it is."""
        used = known or navigating
        self._t = np.array([row["t_s"] for row in used], dtype=np.float64)
        place = np.array([[row[name] for name in POSITION] for row in used], dtype=np.float64).reshape(-1, 3)
        place[:, :2] = np.radians(place[:, :2])
        velocity = np.array([[row[name] for name in VELOCITY] for row in used], dtype=np.float64).reshape(
            -1, 3
        )
        angles = np.radians(np.array([[row[n] for n in ANGLES] for row in used], dtype=np.float64)).reshape(
            -1, 3
        )
        if known:
            errors = np.array([[row[name] for name in _ERRORS] for row in used], dtype=np.float64)
            place[:, :2] -= errors[:, :2] / metres_per_radian(place)
            place[:, 2] += errors[:, 2]
            velocity -= errors[:, 3:6]
            angles -= np.radians(errors[:, 6:9])
        self._place, self._velocity = place, velocity
        self._angles = np.unwrap(angles, axis=0)
        self._rates = np.column_stack((velocity[:, :2] / metres_per_radian(place), -velocity[:, 2]))
        """d/dt of latitude, longitude (rad/s) and height (m/s)."""

    def __len__(self) -> int:
        return len(self._t)

    @property
    def begin_s(self) -> float:
        """Time of the first row."""
        return float(self._t[0])

    @property
    def end_s(self) -> float:
        """Time of the last row."""
        return float(self._t[-1])

    def truth(self, times_ns: NDArray[np.int64], lever_arm: Array | None = None) -> TruthBatch:
        """At instants, of the navigation point or a point at `lever_arm` from it (body axes, m).

        Before the first and after the last row their values hold; NaN in gaps.
        """
        unknown = unknown_bias(len(times_ns))
        place, velocity, angles = self._at(times_ns / 1e9)
        if lever_arm is not None:
            offset = _body_to_ned(angles) @ lever_arm
            place = place.copy()
            place[:, :2] += offset[:, :2] / metres_per_radian(place)
            place[:, 2] -= offset[:, 2]
        yaw = angles[:, 0] % (2.0 * math.pi)
        latitude, longitude, height = place.T
        pitch, roll = angles[:, 1], angles[:, 2]
        return TruthBatch(times_ns, latitude, longitude, height, velocity, yaw, pitch, roll, unknown, unknown)

    def _at(self, t: Array) -> tuple[Array, Array, Array]:
        if len(self._t) < 2:
            nothing = np.full((len(t), 3), math.nan)
            return nothing, nothing, nothing
        clipped = np.clip(t, self._t[0], self._t[-1])
        k = np.clip(np.searchsorted(self._t, clipped, side="right") - 1, 0, len(self._t) - 2)
        step = (self._t[k + 1] - self._t[k])[:, None]
        x = (clipped - self._t[k])[:, None] / step
        y = 1.0 - x
        p0, p1 = self._place[k], self._place[k + 1]
        v0, v1 = self._rates[k], self._rates[k + 1]
        place = p0 + x * x * (3.0 - 2.0 * x) * (p1 - p0) + step * x * y * (y * v0 - x * v1)
        velocity = self._velocity[k] + x * (self._velocity[k + 1] - self._velocity[k])
        angles = self._angles[k] + x * (self._angles[k + 1] - self._angles[k])
        gap = step[:, 0] > LONGEST_STEP_S
        for table in (place, velocity, angles):
            table[gap] = math.nan
        return place, velocity, angles


def metres_per_radian(place: Array) -> Array:
    """North and east, (n, 2)."""
    sine = np.sin(place[:, 0])
    w2 = 1.0 - E2 * sine * sine
    transverse = SEMI_MAJOR / np.sqrt(w2)
    meridian = transverse * (1.0 - E2) / w2
    return np.column_stack((meridian + place[:, 2], (transverse + place[:, 2]) * np.cos(place[:, 0])))


def _body_to_ned(angles: Array) -> Array:
    """C_n_b (n, 3, 3) of yaw, pitch, roll."""
    (sy, sp, sr), (cy, cp, cr) = np.sin(angles).T, np.cos(angles).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
