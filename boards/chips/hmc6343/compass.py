"""From what the chip feels to heading, pitch and roll (fact sheet sections 1, 3 and 5).

With u up (the direction of the specific force at rest), f forward and l = u_nominal × f to the left, all in
the chip's axes, and the field m:

    n = m − (m·u) u,   e = n × u,   heading = atan2(f·e, f·n),   pitch = asin(f·u),   roll = atan2(l·u, up·u)

Pitch is positive nose up, roll right side down. Where the field stands upright or nothing is felt, an angle
that has no meaning is 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
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
Vector = Sequence[float]


@dataclass(frozen=True, slots=True, eq=False)
class Orientation:
    """Which of the chip's axes point forward, left and up: place of the axis among x, y, z, and its sign."""

    forward: tuple[int, float]
    left: tuple[int, float]
    up: tuple[int, float]


LEVEL = Orientation((0, 1.0), (1, 1.0), (2, 1.0))
EDGE = Orientation((0, 1.0), (2, -1.0), (1, 1.0))
FRONT = Orientation((2, 1.0), (1, 1.0), (0, -1.0))


def accelerometer_counts(force: Vector) -> list[int]:
    """Counts of specific force in m/s²."""
    return [round(value / STANDARD_GRAVITY * ACCELEROMETER_COUNTS_PER_G) for value in force]


def limited(field: Vector) -> list[float]:
    """A flux density (T) within the range."""
    return [max(-FIELD_LIMIT_T, min(FIELD_LIMIT_T, value)) for value in field]


def magnetometer_counts(field: Floats) -> Floats:
    """Counts of flux densities in T, not rounded, limited to the range."""
    return np.clip(field, -FIELD_LIMIT_T, FIELD_LIMIT_T) / TESLA_PER_COUNT


def tilt(force: Vector, orientation: Orientation) -> tuple[float, float]:
    """Pitch and roll (degrees) of one sample."""
    length = math.hypot(*force)
    if length == 0.0:
        return 0.0, 0.0
    forward = _along(orientation.forward, force) / length
    pitch = math.asin(max(-1.0, min(1.0, forward)))
    roll = math.atan2(_along(orientation.left, force) / length, _along(orientation.up, force) / length)
    return math.degrees(pitch), math.degrees(roll)


def heading(force: Vector, field: Vector, orientation: Orientation) -> float:
    """Magnetic heading (degrees, 0 … 360) of one sample."""
    length = math.hypot(*force)
    if length == 0.0:
        return 0.0
    x, y, z = (component / length for component in force)
    fx, fy, fz = field
    upright = fx * x + fy * y + fz * z
    north = (fx - upright * x, fy - upright * y, fz - upright * z)
    east = (north[1] * z - north[2] * y, north[2] * x - north[0] * z, north[0] * y - north[1] * x)
    angle = math.atan2(_along(orientation.forward, east), _along(orientation.forward, north))
    return math.degrees(angle) % 360.0


def weighted_heading(headings: Sequence[float]) -> float:
    """Of headings (degrees) in order of time: the newest weighs most, the oldest least, linearly."""
    if len(headings) == 1:
        return headings[0]
    angles = [math.radians(one) for one in headings]
    east = sum(weight * math.sin(angle) for weight, angle in enumerate(angles, 1))
    north = sum(weight * math.cos(angle) for weight, angle in enumerate(angles, 1))
    return math.degrees(math.atan2(east, north)) % 360.0


def _along(axis: tuple[int, float], vector: Vector) -> float:
    place, sign = axis
    return sign * vector[place]
