"""The filters of `..smoothing` in integers: the same integrators, gains in Q31, ages in samples.

A step too small for the last place of an integrator waits in the one before it, until that is large enough:
there is no dead zone, only a last place.
"""

import numpy as np

from firmware.nav.drift.fixed import layout as at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import in_q, product, saturated
from firmware.numerics.fixed.roots import quotient

ROOT_2 = in_q(1.4142135623730951, 30)


@kernel
def keep(d, k, place, value):
    """Store a number; beyond 32 bits it saturates and is counted."""
    d[place] = np.int32(saturated(value, k, at.SATURATIONS))


@kernel
def grown(k, age, settled):
    """Let an age grow by a sample. Returns the weight of this one in the mean, Q30, 0 when past `settled`."""
    if k[age] >= k[settled]:
        return np.int64(0)
    k[age] += 1
    return quotient(np.int64(1), k[age], 30)


@kernel
def smooth(d, k, place, channels, gain, weight, x):
    """Feed one channel of a smoother; returns its output."""
    low = np.int64(d[place + channels])
    if weight > 0:
        low += product(weight, x - low, 30)
        d[place] = 0
        keep(d, k, place + channels, low)
        return low
    g = np.int64(d[gain])
    band = np.int64(d[place])
    rest = x - low - product(ROOT_2 + (g >> 1), band, 30)
    step = product(g, product(rest, np.int64(d[gain + 1]), 30), at.Q_GAIN)
    band += step
    keep(d, k, place, band + step)
    step = product(g, band, at.Q_GAIN)
    low += step
    keep(d, k, place + channels, low + step)
    return low
