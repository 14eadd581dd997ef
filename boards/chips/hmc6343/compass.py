"""From what the chip feels to heading, pitch and roll (fact sheet sections 1, 3 and 5).

With u up (the direction of the specific force at rest), f forward and l = u_nominal × f to the left, all in
the chip's axes, and the field m:

    n = m − (m·u) u,   e = n × u,   heading = atan2(f·e, f·n),   pitch = asin(f·u),   roll = atan2(l·u, up·u)

Pitch is positive nose up, roll right side down. Where the field stands upright or nothing is felt, an angle
that has no meaning is 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STANDARD_GRAVITY = 9.80665
ACCELEROMETER_COUNTS_PER_G = 1024.0
TESLA_PER_COUNT = 1e-8
"""0.1 mgauss."""
FIELD_LIMIT_T = 1.5e-4
"""1500 mgauss."""

Floats = NDArray[np.float64]
_X, _Y, _Z = np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class Orientation:
    """Which of the chip's axes point forward, left and up."""

    forward: Floats
    left: Floats
    up: Floats


LEVEL = Orientation(_X, _Y, _Z)
EDGE = Orientation(_X, -_Z, _Y)
FRONT = Orientation(_Z, _Y, -_X)


def accelerometer_counts(force: Floats) -> Floats:
    """Counts of specific force in m/s²."""
    return np.clip(np.rint(force / STANDARD_GRAVITY * ACCELEROMETER_COUNTS_PER_G), -32768, 32767)


def magnetometer_counts(field: Floats) -> Floats:
    """Counts of flux density in T, not rounded, limited to the range."""
    return np.clip(field, -FIELD_LIMIT_T, FIELD_LIMIT_T) / TESLA_PER_COUNT


def tilt(force: Floats, orientation: Orientation) -> tuple[float, float]:
    """Pitch and roll (degrees) of one sample."""
    length = float(np.linalg.norm(force))
    if length == 0.0:
        return 0.0, 0.0
    up = force / length
    pitch = np.arcsin(np.clip(orientation.forward @ up, -1.0, 1.0))
    roll = np.arctan2(orientation.left @ up, orientation.up @ up)
    return float(np.degrees(pitch)), float(np.degrees(roll))


def heading(force: Floats, field: Floats, orientation: Orientation) -> float:
    """Magnetic heading (degrees, 0 … 360) of one sample."""
    length = float(np.linalg.norm(force))
    if length == 0.0:
        return 0.0
    up = force / length
    north = field - (field @ up) * up
    east = np.cross(north, up)
    angle = np.arctan2(orientation.forward @ east, orientation.forward @ north)
    return float(np.degrees(angle)) % 360.0


def weighted_heading(headings: list[float]) -> float:
    """Of headings (degrees) in order of time: the newest weighs most, the oldest least, linearly."""
    weights = np.arange(1, len(headings) + 1)
    angles = np.radians(headings)
    return float(np.degrees(np.arctan2(weights @ np.sin(angles), weights @ np.cos(angles)))) % 360.0
