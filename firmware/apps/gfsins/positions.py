"""The positions of each procedure: what the operator is told, and what the DSP takes for true.

accelerometers, earth-rate   the document's twelve: where x, y, z point
rates                        an axis up, the table turning about it, right-handed about that axis
compass, ellipse             24 headings on the level, from magnetic north
alignment                    one: at rest
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.nav.gyro_free.twelve_positions import DOCUMENT, felt_at

NAMES: Final = ("accelerometers", "rates", "earth-rate", "compass", "ellipse", "alignment")
TURNED: Final = ("rates", "earth-rate")
"""Collected by what rest and turn differ in; all others by their means at rest."""
HEADINGS: Final = 24
TURNS: Final = tuple((axis, sign * rate) for axis in range(3) for rate in (90, 180) for sign in (1, -1))
"""Axis and °/s."""
COUNTS: Final = {
    "accelerometers": len(DOCUMENT),
    "rates": len(TURNS),
    "earth-rate": len(DOCUMENT),
    "compass": HEADINGS,
    "ellipse": HEADINGS,
    "alignment": 1,
}
STANDARD_GRAVITY: Final = 9.80665
EARTH_RATE: Final = 7.292115e-5


def prompt(name: str, index: int) -> str:
    """At most 21 characters."""
    place = f"{index + 1}/{COUNTS[name]}"
    if name in ("accelerometers", "earth-rate"):
        x, y, z = tuple(DOCUMENT[index])
        return f"{place} x {x}, y {y}, z {z}"
    if name == "rates":
        axis, rate = TURNS[index]
        return f"{place} {'xyz'[axis]} up {rate:+d} deg/s"
    if name == "alignment":
        return f"{place} level, at rest"
    return f"{place} heading {index * 360 // HEADINGS:03d}"


def turn_prompt(name: str, index: int) -> str:
    """While the table turns."""
    return f"turn now {TURNS[index][1]:+d} deg/s" if name == "rates" else "hold still"


def true_heading(index: int) -> float:
    """Magnetic, rad."""
    return 2.0 * math.pi * index / HEADINGS


def true_rate(index: int) -> tuple[float, float, float]:
    """rad/s, axes of the body."""
    axis, rate = TURNS[index]
    turned = [0.0, 0.0, 0.0]
    turned[axis] = math.radians(rate)
    return turned[0], turned[1], turned[2]


def true_force_and_rate(index: int, latitude: float, gravity: float) -> NDArray[np.float64]:
    """Of the twelve positions: specific force (3), rate of the Earth (3), axes of the body."""
    return felt_at(DOCUMENT[index], latitude, gravity, EARTH_RATE)


def gravity_at(latitude: float, height: float) -> float:
    """Normal gravity (Somigliana) and its decrease with height, m/s²."""
    s2 = math.sin(latitude) ** 2
    surface = 9.7803253359 * (1.0 + 0.00193185265 * s2) / math.sqrt(1.0 - 0.0066943799901 * s2)
    return surface - 3.086e-6 * height
