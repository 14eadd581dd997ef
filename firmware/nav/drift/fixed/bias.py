"""Gyro bias in integers: the Kalman filter of `..bias`, its covariance P in (°/s)², Q50.

A row h of a measurement and its variance w move the bias by the gain g = P h / (w + hᵀ P h), in Q32, and take
g (P h)ᵀ off P. P h is read to Q30: of the 0.0009 that are left at rest, to a millionth.
"""

import numpy as np

from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.smoothing import keep, smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import ONE_Q30
from firmware.numerics.fixed.arithmetic import in_q, product, rounded_shift
from firmware.numerics.fixed.quaternion import rotation_matrix
from firmware.numerics.fixed.roots import quotient

LARGEST = in_q(2.0 * 3.141592653589793 / 180.0, at.Q_BIAS)
FIRST_VARIANCE = in_q(0.25, at.Q_VARIANCE)
VARIANCE_SHIFT = at.Q_FINE_VARIANCE - at.Q_VARIANCE
FINE = at.Q_FINE_BIAS - at.Q_BIAS
NOISE = in_q(1.0e-4, 40)
"""(°/s)²/s."""
REST_SETTLED = in_q(0.03**2, at.Q_VARIANCE)
REST_SAMPLES = in_q(0.03**4 / 1.0e-4, 37)
MOTION_SETTLED = in_q(0.1**2, at.Q_VARIANCE)
MOTION_SAMPLES = in_q(0.1**4 / 1.0e-4, 30)
LARGEST_GAIN = (1 << 31) - 1
XX = at.FINE_COVARIANCE
XY = XX + 1
XZ = XX + 2
YY = XX + 3
YZ = XX + 4
ZZ = XX + 5


@kernel
def watch_motion(d, k, weight, w, x, y, z):
    """Smooth the attitude body to level, the bias in it, and the rate about the vertical."""
    r = rotation_matrix(w, x, y, z)
    n = at.MOTION_CHANNELS
    gain = at.FORCE_GAIN
    m = at.MOTION
    bx = np.int64(d[at.GYRO_BIAS])
    by = np.int64(d[at.GYRO_BIAS + 1])
    bz = np.int64(d[at.GYRO_BIAS + 2])
    rx = np.int64(d[at.RATE]) - rounded_shift(bx, at.Q_BIAS - at.Q_RATE)
    ry = np.int64(d[at.RATE + 1]) - rounded_shift(by, at.Q_BIAS - at.Q_RATE)
    rz = np.int64(d[at.RATE + 2]) - rounded_shift(bz, at.Q_BIAS - at.Q_RATE)
    smooth(d, k, m + 8, n, gain, weight, rounded_shift(r[6] * rx + r[7] * ry + r[8] * rz, 30))
    north = smooth(d, k, m + 6, n, gain, weight, rounded_shift(r[0] * bx + r[1] * by + r[2] * bz, 30))
    east = smooth(d, k, m + 7, n, gain, weight, rounded_shift(r[3] * bx + r[4] * by + r[5] * bz, 30))
    return (
        smooth(d, k, m, n, gain, weight, r[0]),
        smooth(d, k, m + 1, n, gain, weight, r[1]),
        smooth(d, k, m + 2, n, gain, weight, r[2]),
        north,
        smooth(d, k, m + 3, n, gain, weight, r[3]),
        smooth(d, k, m + 4, n, gain, weight, r[4]),
        smooth(d, k, m + 5, n, gain, weight, r[5]),
        east,
    )


@kernel
def learn_at_rest(d, k):
    """The smoothed rate is the bias."""
    w = REST_SETTLED + product(np.int64(d[at.PER_PERIOD]), REST_SAMPLES, at.Q_PER_PERIOD + 37 - at.Q_VARIANCE)
    ex, ey, ez = _rest_error(d, 0), _rest_error(d, 1), _rest_error(d, 2)
    by = k[at.FINE_BIAS + 1]
    bz = k[at.FINE_BIAS + 2]
    one = np.int64(ONE_Q30)
    none = np.int64(0)
    _absorb(d, k, w, one, none, none, ex)
    _absorb(d, k, w, none, one, none, ey - rounded_shift(k[at.FINE_BIAS + 1] - by, FINE))
    _absorb(d, k, w, none, none, one, ez - rounded_shift(k[at.FINE_BIAS + 2] - bz, FINE))


@kernel
def _rest_error(d, axis):
    rate = np.int64(d[at.REST_RATE + 3 + axis]) << (at.Q_BIAS - at.Q_RATE)
    return _limited(rate - np.int64(d[at.GYRO_BIAS + axis]))


@kernel
def learn_in_motion(d, k, n_x, n_y, n_z, north, e_x, e_y, e_z, east):
    """Rows of R̄ for north and east, and the smoothed bias estimate in them."""
    w = MOTION_SETTLED + product(
        np.int64(d[at.PER_PERIOD]), MOTION_SAMPLES, at.Q_PER_PERIOD + 30 - at.Q_VARIANCE
    )
    bx = np.int64(d[at.GYRO_BIAS])
    by = np.int64(d[at.GYRO_BIAS + 1])
    bz = np.int64(d[at.GYRO_BIAS + 2])
    seen = rounded_shift(n_x * bx + n_y * by + n_z * bz, 30)
    north = _limited(north - np.int64(d[at.LEVEL_RATE]) - seen)
    seen = rounded_shift(e_x * bx + e_y * by + e_z * bz, 30)
    east = _limited(east - np.int64(d[at.LEVEL_RATE + 1]) - seen)
    _absorb(d, k, w, n_x, n_y, n_z, north)
    dx = np.int64(d[at.GYRO_BIAS]) - bx
    dy = np.int64(d[at.GYRO_BIAS + 1]) - by
    dz = np.int64(d[at.GYRO_BIAS + 2]) - bz
    _absorb(d, k, w, e_x, e_y, e_z, east - rounded_shift(e_x * dx + e_y * dy + e_z * dz, 30))


@kernel
def forget(d, k):
    """Process noise; an axis never becomes more uncertain than it was at first."""
    noise = product(NOISE, np.int64(d[at.PERIOD]), 40 + at.Q_PERIOD - at.Q_FINE_VARIANCE)
    most = np.int64(FIRST_VARIANCE) << VARIANCE_SHIFT
    if k[XX] < most:
        k[XX] += noise
    if k[YY] < most:
        k[YY] += noise
    if k[ZZ] < most:
        k[ZZ] += noise


@kernel
def vertical_variance(k, x, y, z):
    """Variance of the bias along a body direction in Q30, (°/s)² in Q30."""
    px, py, pz = _projected(k, x, y, z)
    return max(rounded_shift(x * px + y * py + z * pz, 30), np.int64(0))


@kernel
def _projected(k, x, y, z):
    """P times a direction."""
    xx, xy, xz = _element(k, XX), _element(k, XY), _element(k, XZ)
    yy, yz, zz = _element(k, YY), _element(k, YZ), _element(k, ZZ)
    return (
        rounded_shift(xx * x + xy * y + xz * z, 30),
        rounded_shift(xy * x + yy * y + yz * z, 30),
        rounded_shift(xz * x + yz * y + zz * z, 30),
    )


@kernel
def _element(k, place):
    return rounded_shift(k[place], VARIANCE_SHIFT)


@kernel
def _absorb(d, k, w, x, y, z, innovation):
    """One scalar measurement with the row (x, y, z) and the variance w."""
    px, py, pz = _projected(k, x, y, z)
    total = max(w + rounded_shift(x * px + y * py + z * pz, 30), w)
    gx, gy, gz = _gain(px, total), _gain(py, total), _gain(pz, total)
    _move(d, k, 0, gx, innovation)
    _move(d, k, 1, gy, innovation)
    _move(d, k, 2, gz, innovation)
    bits = 32 + at.Q_VARIANCE - at.Q_FINE_VARIANCE
    k[XX] = max(k[XX] - product(gx, px, bits), np.int64(0))
    k[XY] -= product(gx, py, bits)
    k[XZ] -= product(gx, pz, bits)
    k[YY] = max(k[YY] - product(gy, py, bits), np.int64(0))
    k[YZ] -= product(gy, pz, bits)
    k[ZZ] = max(k[ZZ] - product(gz, pz, bits), np.int64(0))


@kernel
def _gain(p, total):
    gain = quotient(p, total, 32)
    return min(max(gain, np.int64(-LARGEST_GAIN)), np.int64(LARGEST_GAIN))


@kernel
def _move(d, k, axis, gain, error):
    """One component of the bias, by an error of at most twice LARGEST."""
    moved = k[at.FINE_BIAS + axis] + product(gain, error, 32 + at.Q_BIAS - at.Q_FINE_BIAS)
    end = np.int64(LARGEST) << FINE
    k[at.FINE_BIAS + axis] = min(max(moved, -end), end)
    keep(d, k, at.GYRO_BIAS + axis, rounded_shift(k[at.FINE_BIAS + axis], FINE))


@kernel
def _limited(x):
    """An innovation within ±2 °/s; that it is not is no fault of the format."""
    return min(max(x, np.int64(-LARGEST)), np.int64(LARGEST))
