"""What becomes of levelling and heading when an angle was lost: gyros saturated, samples missing.

The mean of the force over a time T levels with a standard deviation of v/(g T), v being by how much the
velocity changes: 1 m/s for hands, which move to and fro. With the attitude now uncertain by σ more, what
was averaged is worth as much as a mean over a shorter time T':

    1/T'² = 1/T² + σ² (g/v)²

The variance of the heading grows by σ². Motion tells nothing about the bias for a while.
"""

import math

import numpy as np

from firmware.nav.drift import layout as at
from firmware.numerics.dialect import kernel

ONE = np.float32(1.0)
SMALLEST = np.float32(0.002)
"""rad: less is nothing."""
SHORTEST = np.float32(0.01)
"""s."""
GRAVITY_PER_SPEED_SQUARE = np.float32(9.80665**2)
LARGEST_VARIANCE = np.float32(1.0)
PAUSE = np.float32(6.0)
PAUSE_AFTER = np.float32(0.02)


@kernel
def lose(d, k, sigma):
    """The attitude has become uncertain by sigma more, rad."""
    if not sigma > SMALLEST:
        return
    square = sigma * sigma
    age = d[at.FORCE_AGE]
    younger = age / np.float32(math.sqrt(ONE + age * age * square * GRAVITY_PER_SPEED_SQUARE))
    d[at.FORCE_AGE] = max(younger, SHORTEST)
    d[at.HEADING_VARIANCE] = min(d[at.HEADING_VARIANCE] + square, LARGEST_VARIANCE)
    if sigma > PAUSE_AFTER:
        d[at.BIAS_PAUSE] = PAUSE
    k[at.LOSSES] += 1
