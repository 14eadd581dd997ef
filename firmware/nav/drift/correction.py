"""The door after the board's attitude loop: its turn, our corrections.

The loop carries q_nb over an iteration with all its samples. What it turned since the last correction,
Δ = q_nb(corrected)* ⊗ q_nb(now), moves the free frame; force and field of the newest sample then correct, and
the corrected q_nb and gyro bias go back. Rates are looked at for rest, saturation and what was missed.
"""

import numpy as np

from firmware.nav.attitude import flags as noticed
from firmware.nav.attitude import layout as loop
from firmware.nav.drift import layout as at
from firmware.nav.drift.fusion import begin, fuse, is_gap, turn_free
from firmware.nav.drift.levelling import TAU as FORCE_TAU
from firmware.nav.drift.rates import take_rate
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import normalise_quaternion, quaternion_product

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
SERIES_2 = np.float32(1.0 / 6.0)
SERIES_4 = np.float32(3.0 / 40.0)
NAN = np.float32(np.nan)
GRAVITY = np.float32(9.80665)
ALIGNED_AGE = np.float32(2.0)
"""s of averaging that the loop's alignment counts for."""
LARGEST_DIFFERENCE = np.float32(0.3)
"""rad between the loop's turn and that of the newest rate: more, and the attitude was set anew."""


@kernel("int64(float32[::1], int64[::1], float32[::1], int64[::1])")
def correct(s, i, d, k):
    """Correct the loop's QUATERNION and GYRO_BIAS after an `iterate` that returned 1; returns k[FLAGS].

    s, i: of the loop; d, k: of this filter. Does nothing while the loop aligns."""
    if i[loop.MODE] != noticed.RUNNING:
        return np.int64(0)
    d[at.DECLINATION] = s[loop.DECLINATION]
    d[at.GYRO_DELAY] = ZERO  # what goes back to the loop must not be ahead of it
    if k[at.SAMPLES] == 0:
        _adopt(s, d)
    dt = s[loop.PERIOD]
    if not begin(d, k, dt):
        return k[at.FLAGS]
    bridged = i[loop.NOTICED] & noticed.BRIDGED != 0
    without_rates = i[loop.NOTICED] & (noticed.BRIDGED | noticed.RATES_LOST) != 0
    o = loop.OMEGA + loop.NEWEST
    mx, my, mz = s[o], s[o + 1], s[o + 2]
    if without_rates:
        x, y, z = take_rate(d, k, dt, is_gap(k), NAN, NAN, NAN)
    else:
        x, y, z = take_rate(d, k, dt, is_gap(k), mx, my, mz)
        # The loop turned by what the sensor told, this filter by no more than its range.
        x = x + (d[at.RATE] - mx) * dt
        y = y + (d[at.RATE + 1] - my) * dt
        z = z + (d[at.RATE + 2] - mz) * dt
    tx, ty, tz = _turned(s, d)
    dx = tx - (d[at.RATE] - s[loop.GYRO_BIAS]) * dt
    dy = ty - (d[at.RATE + 1] - s[loop.GYRO_BIAS + 1]) * dt
    dz = tz - (d[at.RATE + 2] - s[loop.GYRO_BIAS + 2]) * dt
    if dx * dx + dy * dy + dz * dz > LARGEST_DIFFERENCE * LARGEST_DIFFERENCE:
        _adopt(s, d)
    else:
        turn_free(d, tx + x, ty + y, tz + z)
    f = loop.FORCE + loop.NEWEST
    m = loop.FIELD
    fx, fy, fz = s[f], s[f + 1], s[f + 2]
    mx, my, mz = s[m], s[m + 1], s[m + 2]
    if bridged:
        fx = NAN
    if bridged or i[loop.USE_FIELD] == 0:
        mx = NAN
    fuse(d, k, dt, fx, fy, fz, mx, my, mz)
    for j in range(np.int32(4)):
        s[loop.QUATERNION + j] = d[at.Q_NB + j]
    for j in range(np.int32(3)):
        s[loop.GYRO_BIAS + j] = d[at.GYRO_BIAS + j]
    return k[at.FLAGS]


@kernel
def _adopt(s, d):
    """Begin with the attitude and bias of the loop: the free frame is north-east-down."""
    for j in range(np.int32(4)):
        d[at.Q_FREE + j] = s[loop.QUATERNION + j]
        d[at.Q_NB + j] = s[loop.QUATERNION + j]
        d[at.Q_LEVEL + j] = ZERO
    d[at.Q_LEVEL] = ONE
    d[at.HEADING] = ZERO
    for j in range(np.int32(3)):
        d[at.GYRO_BIAS + j] = s[loop.GYRO_BIAS + j]
        d[at.FORCE + j] = ZERO
        d[at.FORCE + 3 + j] = ZERO
    d[at.FORCE + 5] = -GRAVITY
    d[at.FORCE_AGE] = min(ALIGNED_AGE, FORCE_TAU)
    d[at.HEADING_AGE] = ALIGNED_AGE


@kernel
def _turned(s, d):
    """Rotation vector (body axes, rad) of what the loop turned since the last correction, for small turns.

    φ = 2 arcsin|v| v/|v| of the quaternion's vector part v; 0.1 rad is right to 1e-10."""
    p = at.Q_NB
    q = loop.QUATERNION
    w, x, y, z = quaternion_product(d[p], -d[p + 1], -d[p + 2], -d[p + 3], s[q], s[q + 1], s[q + 2], s[q + 3])
    w, x, y, z = normalise_quaternion(w, x, y, z)
    square = x * x + y * y + z * z
    scale = TWO * (ONE + square * (SERIES_2 + square * SERIES_4))
    if w < ZERO:
        scale = -scale
    return x * scale, y * scale, z * scale
