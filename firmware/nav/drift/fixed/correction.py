"""The door after the board's attitude loop in fixed point (`..correction`): its turn, our corrections."""

import numpy as np

from firmware.nav.attitude import flags as noticed
from firmware.nav.attitude.fixed import layout as loop
from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.fusion import fuse, take_rates, turn_free
from firmware.nav.drift.fixed.levelling import quaternion_at
from firmware.nav.drift.fixed.smoothing import keep
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import ONE_Q30
from firmware.numerics.fixed.arithmetic import in_q, product, rounded_shift
from firmware.numerics.fixed.quaternion import quaternion_product

THREE = np.int32(3)
FOUR = np.int32(4)
RATE_SHIFT = loop.Q_RATE - at.Q_RATE
BIAS_SHIFT = at.Q_BIAS - loop.Q_RATE
SIXTH = in_q(1.0 / 6.0, 30)
GRAVITY = in_q(9.80665, at.Q_FORCE)
LARGEST_TURN = in_q(0.3, 30)
"""Half the angle, rad, of a turn that can be of one iteration: more, and the attitude was set anew."""


@kernel("int64(int32[::1], int64[::1], int32[::1], int64[::1])")
def correct(s, i, d, k):
    """Correct the loop's QUATERNION and GYRO_BIAS after an `iterate` that returned 1; returns k[FLAGS].

    s, i: of the loop; d, k: of this filter, its period that of an iteration. Nothing while the loop aligns.
    """
    if i[loop.MODE] != noticed.RUNNING:
        return np.int64(0)
    k[at.FLAGS] = 0
    d[at.DECLINATION] = s[loop.DECLINATION]
    if k[at.SAMPLES] == 0:
        _adopt(s, d, k)
    bridged = i[loop.NOTICED] & noticed.BRIDGED != 0
    without_rates = i[loop.NOTICED] & (noticed.BRIDGED | noticed.RATES_LOST) != 0
    o = loop.OMEGA + loop.NEWEST
    f = loop.FORCE + loop.NEWEST
    m = loop.FIELD
    if without_rates:
        take_rates(d, k, np.int32(at.MISSING), np.int32(at.MISSING), np.int32(at.MISSING))
    else:
        take_rates(d, k, _rate(s[o]), _rate(s[o + 1]), _rate(s[o + 2]))
    w, x, y, z = _turned(s, d)
    if max(max(abs(x), abs(y)), abs(z)) > LARGEST_TURN or w <= 0:
        _adopt(s, d, k)
    else:
        # φ = 2 arcsin|v| v/|v| in Q32 of the vector part v in Q30
        square = rounded_shift(x * x + y * y + z * z, 30)
        scale = ONE_Q30 + product(square, SIXTH, 30)
        turn_free(d, k, product(x, scale, 27), product(y, scale, 27), product(z, scale, 27))
    fx, fy, fz = s[f], s[f + 1], s[f + 2]
    mx, my, mz = s[m], s[m + 1], s[m + 2]
    if bridged:
        fx = np.int32(at.MISSING)
    if bridged or i[loop.USE_FIELD] == 0:
        mx = np.int32(at.MISSING)
    fuse(d, k, fx, fy, fz, mx, my, mz)
    for j in range(FOUR):
        s[loop.QUATERNION + j] = d[at.Q_NB + j]
    for j in range(THREE):
        keep(s, k, loop.GYRO_BIAS + j, rounded_shift(np.int64(d[at.GYRO_BIAS + j]), BIAS_SHIFT))
    return k[at.FLAGS]


@kernel
def _rate(rate):
    return np.int32(rounded_shift(np.int64(rate), RATE_SHIFT))


@kernel
def _adopt(s, d, k):
    """Begin with the attitude and bias of the loop: the free frame is north-east-down."""
    for j in range(FOUR):
        d[at.Q_FREE + j] = s[loop.QUATERNION + j]
        d[at.Q_NB + j] = s[loop.QUATERNION + j]
        d[at.Q_LEVEL + j] = 0
    d[at.Q_LEVEL] = ONE_Q30
    d[at.HEADING] = 0
    k[at.FINE_HEADING] = 0
    for j in range(THREE):
        bias = np.int64(s[loop.GYRO_BIAS + j]) << BIAS_SHIFT
        keep(d, k, at.GYRO_BIAS + j, bias)
        k[at.FINE_BIAS + j] = bias << (at.Q_FINE_BIAS - at.Q_BIAS)
        d[at.FORCE + j] = 0
        d[at.FORCE + 3 + j] = 0
    d[at.FORCE + 5] = -GRAVITY
    k[at.FORCE_AGE] = k[at.ALIGNED_AGES]
    k[at.HEADING_AGE] = k[at.ALIGNED_AGES + 1]


@kernel
def _turned(s, d):
    """Quaternion of what the loop turned since the last correction, Q30, scalar positive."""
    p = at.Q_NB
    bw, bx, by, bz = quaternion_at(s, loop.QUATERNION)
    w, x, y, z = quaternion_product(
        np.int64(d[p]), -np.int64(d[p + 1]), -np.int64(d[p + 2]), -np.int64(d[p + 3]), bw, bx, by, bz, 30
    )
    if w < 0:
        w, x, y, z = -w, -x, -y, -z
    return w, x, y, z
