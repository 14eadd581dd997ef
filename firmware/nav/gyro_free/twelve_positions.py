"""The document's twelve positions: which way the axes point, and what they should feel.

Directions are those of the document's table 3.1; its columns of gravity and Earth rate have misprints (four
rows say the same rate for opposite axes), so both follow from the directions here. An accelerometer at rest
feels −g: nothing is added to its sign, f = −g along down.
"""

import math

import numpy as np
from numpy.typing import NDArray

DIRECTIONS = {
    "N": (1.0, 0.0, 0.0), "S": (-1.0, 0.0, 0.0),
    "E": (0.0, 1.0, 0.0), "W": (0.0, -1.0, 0.0),
    "D": (0.0, 0.0, 1.0), "U": (0.0, 0.0, -1.0),
}  # fmt: skip
"""In north, east, down."""
DOCUMENT = (
    "WND", "NED", "ESD", "SWD",
    "DWN", "NWU", "UWS", "SWD",
    "WND", "WUN", "WSU", "WDS",
)  # fmt: skip
"""Where x, y, z point in positions 1.1 … 3.4, as printed."""


def position_axes(names: str) -> NDArray[np.float64]:
    """C_b_n (3, 3) of axes named like "NED": row k is axis k in north, east, down."""
    return np.array([DIRECTIONS[name] for name in names])


def felt_at(names: str, latitude: float, gravity: float, earth_rate: float) -> NDArray[np.float64]:
    """Specific force (3) and Earth rate (3) in the axes of the body."""
    axes = position_axes(names)
    force = axes @ np.array((0.0, 0.0, -gravity))
    rate = axes @ (earth_rate * np.array((math.cos(latitude), 0.0, -math.sin(latitude))))
    return np.concatenate((force, rate))
