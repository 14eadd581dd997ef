"""When the accelerometer says nothing about the vertical, in integers: see `holding`. No float occurs.

Memory `g`, int64: ω̄ (3, Q35: the rate's Q27 and 8 bits more), |f|‾ and |f|₀ (Q29: Q21 and 8 bits more), the
force withheld (3, as in `s`), whether it is, what `fixed_disagreement` keeps (3).
Limits are met at the same sample as in float64, but for one in many thousand: forces and means are kept to
1e-6 of what they are compared with.
"""

import math
from typing import Final

import numpy as np

from firmware.apps.uav_ahrs.holding import (
    AT_REST,
    HOLDING_SIZE,
    IS_WITHHELD,
    NORM,
    RATE,
    WITHHELD,
)
from firmware.nav.attitude.fixed import layout as at
from firmware.nav.drift.fixed.layout import MISSING
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import in_q, leading_bit, product, rounded_shift
from firmware.numerics.fixed.roots import quotient, square_root

FIXED_HOLDING_SIZE: Final = HOLDING_SIZE
MORE: Final = 8
"""Bits of the means behind those of their values."""
FORCE_SHIFT: Final = 1
"""Off a force in Q22 before it is squared."""
SUM_FORCE: Final = at.FIXED_SUMS + 3
SHARE_Q: Final = 28
SHARE: Final = in_q(0.008 / 0.5, SHARE_Q)
"""Period over TAU."""
RATE_SHIFT: Final = 1
"""Off a mean rate in Q27 before it is squared."""
RATE_SQUARE: Final = round((math.radians(3.0) * 2.0 ** (at.Q_RATE - RATE_SHIFT)) ** 2)
NORM_LIMIT: Final = round(0.1 * (1 << (at.Q_FORCE - FORCE_SHIFT + MORE)))


@kernel
def length(x, y, z):
    """Of three forces in Q22, in Q21."""
    x >>= np.int64(FORCE_SHIFT)
    y >>= np.int64(FORCE_SHIFT)
    z >>= np.int64(FORCE_SHIFT)
    return square_root(x * x + y * y + z * z)


@kernel
def mean_force(i, n):
    """Of the alignment, Q22."""
    total = i[SUM_FORCE + n]
    bits = max(leading_bit(abs(total)) - 29, np.int64(0))
    return quotient(total >> bits, i[at.ALIGNMENT_COUNT], bits)


@kernel
def follow(g, place, value):
    """Let a mean go on by a value."""
    g[place] += product((value << MORE) - g[place], SHARE, SHARE_Q)


@kernel
def begin(s, i, g):
    """The force of the alignment, or of now where there was none."""
    f = at.FORCE + at.NEWEST
    if i[at.ALIGNMENT_COUNT] > 0:
        norm = length(mean_force(i, 0), mean_force(i, 1), mean_force(i, 2))
    else:
        norm = length(np.int64(s[f]), np.int64(s[f + 1]), np.int64(s[f + 2]))
    g[AT_REST] = norm << np.int64(MORE)
    g[NORM] = g[AT_REST]


@kernel
def withhold_force(s, i, g, regaining):
    """As `holding.withhold_force`."""
    if g[AT_REST] == 0:
        begin(s, i, g)
    square = np.int64(0)
    for n in range(np.int32(3)):
        rate = np.int64(s[at.OMEGA + at.NEWEST + n]) - np.int64(s[at.GYRO_BIAS + n])
        follow(g, RATE + n, rate)
        mean = rounded_shift(g[RATE + n], MORE + RATE_SHIFT)
        square += mean * mean
    f = at.FORCE + at.NEWEST
    norm = length(np.int64(s[f]), np.int64(s[f + 1]), np.int64(s[f + 2]))
    follow(g, NORM, norm)
    turns = square > np.int64(RATE_SQUARE) or abs(g[NORM] - g[AT_REST]) > np.int64(NORM_LIMIT)
    withheld = turns and not regaining
    g[IS_WITHHELD] = np.int64(1) if withheld else np.int64(0)
    if withheld:
        for n in range(np.int32(3)):
            g[WITHHELD + n] = np.int64(s[f + n])
            s[f + n] = np.int32(MISSING)


@kernel
def give_back(s, g):
    """The force again, which velocity needs."""
    if g[IS_WITHHELD] != 0:
        for n in range(np.int32(3)):
            s[at.FORCE + at.NEWEST + n] = np.int32(g[WITHHELD + n])
