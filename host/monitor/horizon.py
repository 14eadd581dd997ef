"""The artificial horizon: what a window in the nose would show, ground dotted, and a compass strip below.

A dot at (x right, y down) from the middle lies at the elevation
    pitch − (x sin φ + y cos φ) · degrees a dot,   φ the roll, right side down.
"""

from __future__ import annotations

import math

import numpy as np
from rich.text import Text

from host.monitor.braille import ACROSS, DOWN, Mask, paint

HALF_VIEW_DEG = 15.0
"""From the middle to the upper edge."""
LADDER_DEG = 10.0
DEGREES_A_SIGN = 4
POINTS = {0: "N", 45: "NE", 90: "E", 135: "SE", 180: "S", 225: "SW", 270: "W", 315: "NW"}
WINGS = "━╸•╺━"


def horizon(pitch_deg: float, roll_deg: float, width: int, height: int) -> list[Text]:
    """`height` lines of `width` characters."""
    if not (math.isfinite(pitch_deg) and math.isfinite(roll_deg)):
        return [Text("no attitude".center(width), "dim")] + [Text()] * (height - 1)
    rows, columns = height * DOWN, width * ACROSS
    degrees_a_dot = 2 * HALF_VIEW_DEG / rows
    y, x = np.mgrid[0:rows, 0:columns]
    y = y - (rows - 1) / 2
    x = x - (columns - 1) / 2
    roll = math.radians(roll_deg)
    # a pitch beyond the window leaves a strip of what is missing at its edge
    limit = HALF_VIEW_DEG - degrees_a_dot
    pitch = min(max(pitch_deg, -limit), limit)
    elevation = pitch - (x * math.sin(roll) + y * math.cos(roll)) * degrees_a_dot
    along = x * math.cos(roll) - y * math.sin(roll)
    line = np.abs(elevation) <= degrees_a_dot * 0.5
    dotted = ((x + y) % 2 == 0) & (y.astype(int) % 2 == 0)
    ground = (elevation < -degrees_a_dot) & dotted
    ladder = np.zeros_like(line)
    for rung in (-LADDER_DEG, LADDER_DEG):
        ladder |= (np.abs(elevation - rung) <= degrees_a_dot * 0.5) & (np.abs(along) <= columns / 12)
    layers: list[tuple[Mask, str]] = [(ground, "yellow"), (ladder, "white"), (line, "bold cyan")]
    middle = height // 2 if height % 2 else (height - 1) // 2
    first = (width - len(WINGS)) // 2
    marks = {(middle, first + k): (sign, "bold magenta") for k, sign in enumerate(WINGS)}
    return paint(layers, marks)


def compass(yaw_deg: float, width: int) -> Text:
    """A strip of headings with the present one in the middle."""
    if not math.isfinite(yaw_deg):
        return Text()
    signs = [" "] * width
    middle = width // 2
    at_middle = round(yaw_deg / DEGREES_A_SIGN)
    for column in range(width):
        heading = (at_middle + column - middle) * DEGREES_A_SIGN
        nearest = 15 * round(heading / 15)
        if abs(heading - nearest) * 2 < DEGREES_A_SIGN or heading - nearest == -DEGREES_A_SIGN / 2:
            signs[column] = "·"
            name = POINTS.get(nearest % 360)
            if name is not None and column + len(name) <= width:
                signs[column : column + len(name)] = name
    text = Text("".join(signs)[:width], "cyan", no_wrap=True)
    text.stylize("bold reverse", middle, middle + 1)
    return text
