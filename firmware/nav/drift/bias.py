"""Gyro bias by a Kalman filter of three states (after Laidig & Seel 2023).

At rest the smoothed rate is the bias. In motion, levelling turns the level frame at the rate that bias errors
turn the free frame: with R body to level, smoothed as the force is (a bar),

    −c = R̄ b − (R b̂)‾  in north and east,      so  R̄ (b − b̂) = −c + (R b̂)‾ − R̄ b̂,

c being the rate of levelling. The variance W of one sample follows from the standard deviation σ that the
filter shall settle at: with a process noise V a sample, W = σ⁴/V + σ². The bias is held within ±2 °/s, so are
innovations. Rows are absorbed one after the other, which is the same as at once for independent noise.
"""

import numpy as np

from firmware.nav.drift import layout as at
from firmware.nav.drift.smoothing import smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import rotation_matrix

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
FIRST_VARIANCE = np.float32((0.5 * 3.141592653589793 / 180.0) ** 2)
PROCESS_DENSITY = np.float32((0.1 * 3.141592653589793 / 180.0) ** 2 / 100.0)
"""(rad/s)²/s: 0.1 °/s in 100 s."""
REST_VARIANCE = np.float32((0.03 * 3.141592653589793 / 180.0) ** 2)
MOTION_VARIANCE = np.float32((0.1 * 3.141592653589793 / 180.0) ** 2)
LARGEST = np.float32(2.0 * 3.141592653589793 / 180.0)
XX = at.BIAS_COVARIANCE
XY = XX + 1
XZ = XX + 2
YY = XX + 3
YZ = XX + 4
ZZ = XX + 5


@kernel
def watch_motion(d, weight, w, x, y, z):
    """Smooth the attitude body to level (w, x, y, z), the bias in it, and the rate about the vertical.

    Returns the rows of R̄ for north and east, each with the smoothed bias in it."""
    r = rotation_matrix(w, x, y, z)
    bx = d[at.GYRO_BIAS]
    by = d[at.GYRO_BIAS + 1]
    bz = d[at.GYRO_BIAS + 2]
    n = at.MOTION_CHANNELS
    gain = at.FORCE_GAIN
    m = (
        smooth(d, at.MOTION, n, gain, weight, r[0]),
        smooth(d, at.MOTION + 1, n, gain, weight, r[1]),
        smooth(d, at.MOTION + 2, n, gain, weight, r[2]),
        smooth(d, at.MOTION + 3, n, gain, weight, r[3]),
        smooth(d, at.MOTION + 4, n, gain, weight, r[4]),
        smooth(d, at.MOTION + 5, n, gain, weight, r[5]),
    )
    north = smooth(d, at.MOTION + 6, n, gain, weight, r[0] * bx + r[1] * by + r[2] * bz)
    east = smooth(d, at.MOTION + 7, n, gain, weight, r[3] * bx + r[4] * by + r[5] * bz)
    rate = r[6] * (d[at.RATE] - bx) + r[7] * (d[at.RATE + 1] - by) + r[8] * (d[at.RATE + 2] - bz)
    smooth(d, at.MOTION + 8, n, gain, weight, rate)
    return m[0], m[1], m[2], north, m[3], m[4], m[5], east


@kernel
def forget(d, dt):
    """Process noise; an axis never becomes more uncertain than it was at first."""
    noise = PROCESS_DENSITY * dt
    if d[XX] < FIRST_VARIANCE:
        d[XX] = d[XX] + noise
    if d[YY] < FIRST_VARIANCE:
        d[YY] = d[YY] + noise
    if d[ZZ] < FIRST_VARIANCE:
        d[ZZ] = d[ZZ] + noise


@kernel
def learn_at_rest(d, dt):
    """The smoothed rate is the bias."""
    w = _variance(REST_VARIANCE, dt)
    low = at.REST_RATE + 3
    ex = _limited(d[low] - d[at.GYRO_BIAS])
    ey = _limited(d[low + 1] - d[at.GYRO_BIAS + 1])
    ez = _limited(d[low + 2] - d[at.GYRO_BIAS + 2])
    by = d[at.GYRO_BIAS + 1]
    bz = d[at.GYRO_BIAS + 2]
    _absorb(d, w, ONE, ZERO, ZERO, ex)
    _absorb(d, w, ZERO, ONE, ZERO, ey - (d[at.GYRO_BIAS + 1] - by))
    _absorb(d, w, ZERO, ZERO, ONE, ez - (d[at.GYRO_BIAS + 2] - bz))
    _hold_within(d)


@kernel
def learn_in_motion(d, dt, n_x, n_y, n_z, north, e_x, e_y, e_z, east):
    """Rows of R̄ for north and east, and the smoothed bias estimate in them."""
    w = _variance(MOTION_VARIANCE, dt)
    bx = d[at.GYRO_BIAS]
    by = d[at.GYRO_BIAS + 1]
    bz = d[at.GYRO_BIAS + 2]
    e = _limited(north - d[at.LEVEL_RATE] - (n_x * bx + n_y * by + n_z * bz))
    _absorb(d, w, n_x, n_y, n_z, e)
    e = _limited(east - d[at.LEVEL_RATE + 1] - (e_x * bx + e_y * by + e_z * bz))
    dx = d[at.GYRO_BIAS] - bx
    dy = d[at.GYRO_BIAS + 1] - by
    dz = d[at.GYRO_BIAS + 2] - bz
    _absorb(d, w, e_x, e_y, e_z, e - (e_x * dx + e_y * dy + e_z * dz))
    _hold_within(d)


@kernel
def vertical_variance(d, x, y, z):
    """Variance of the bias along a body direction, (rad/s)²."""
    px = d[XX] * x + d[XY] * y + d[XZ] * z
    py = d[XY] * x + d[YY] * y + d[YZ] * z
    pz = d[XZ] * x + d[YZ] * y + d[ZZ] * z
    return max(x * px + y * py + z * pz, ZERO)


@kernel
def _variance(settled, dt):
    return settled * settled / (PROCESS_DENSITY * dt) + settled


@kernel
def _limited(x):
    return min(max(x, -LARGEST), LARGEST)


@kernel
def _absorb(d, w, x, y, z, innovation):
    """One scalar measurement with the row (x, y, z) and the variance w."""
    px = d[XX] * x + d[XY] * y + d[XZ] * z
    py = d[XY] * x + d[YY] * y + d[YZ] * z
    pz = d[XZ] * x + d[YZ] * y + d[ZZ] * z
    inverse = ONE / (w + x * px + y * py + z * pz)
    gx = px * inverse
    gy = py * inverse
    gz = pz * inverse
    d[at.GYRO_BIAS] = d[at.GYRO_BIAS] + gx * innovation
    d[at.GYRO_BIAS + 1] = d[at.GYRO_BIAS + 1] + gy * innovation
    d[at.GYRO_BIAS + 2] = d[at.GYRO_BIAS + 2] + gz * innovation
    d[XX] = d[XX] - gx * px
    d[XY] = d[XY] - gx * py
    d[XZ] = d[XZ] - gx * pz
    d[YY] = d[YY] - gy * py
    d[YZ] = d[YZ] - gy * pz
    d[ZZ] = d[ZZ] - gz * pz


@kernel
def _hold_within(d):
    d[at.GYRO_BIAS] = _limited(d[at.GYRO_BIAS])
    d[at.GYRO_BIAS + 1] = _limited(d[at.GYRO_BIAS + 1])
    d[at.GYRO_BIAS + 2] = _limited(d[at.GYRO_BIAS + 2])
