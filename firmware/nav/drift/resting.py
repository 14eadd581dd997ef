"""Rest: rates and forces stay close to their smoothed values for a while (Laidig & Seel 2023)."""

import numpy as np

from firmware.nav.drift import layout as at
from firmware.nav.drift.smoothing import grown, smooth
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
TAU = np.float32(0.5)
REST_AFTER = np.float32(1.5)
STILL_RATE = np.float32((2.0 * 3.141592653589793 / 180.0) ** 2)
STILL_FORCE = np.float32(0.25)
"""Squares of 2 °/s and 0.5 m/s²."""
LARGEST_BIAS = np.float32(2.0 * 3.141592653589793 / 180.0)


@kernel
def watch_rates(d, dt, x, y, z):
    """Smooth the measured rates; a smoothed rate beyond any bias is a turn."""
    weight = grown(d, at.REST_RATE_AGE, dt, TAU)
    x = x - smooth(d, at.REST_RATE, 3, at.REST_GAIN, weight, x)
    y = y - smooth(d, at.REST_RATE + 1, 3, at.REST_GAIN, weight, y)
    z = z - smooth(d, at.REST_RATE + 2, 3, at.REST_GAIN, weight, z)
    low = at.REST_RATE + 3
    largest = max(abs(d[low]), max(abs(d[low + 1]), abs(d[low + 2])))
    if x * x + y * y + z * z >= STILL_RATE or largest > LARGEST_BIAS:
        d[at.REST_TIME] = ZERO


@kernel
def watch_forces(d, dt, x, y, z):
    """Smooth the forces, body axes; returns whether the body rests."""
    weight = grown(d, at.REST_FORCE_AGE, dt, TAU)
    x = x - smooth(d, at.REST_FORCE, 3, at.REST_GAIN, weight, x)
    y = y - smooth(d, at.REST_FORCE + 1, 3, at.REST_GAIN, weight, y)
    z = z - smooth(d, at.REST_FORCE + 2, 3, at.REST_GAIN, weight, z)
    if x * x + y * y + z * z >= STILL_FORCE:
        d[at.REST_TIME] = ZERO
    else:
        d[at.REST_TIME] = d[at.REST_TIME] + dt
    return d[at.REST_TIME] >= REST_AFTER
