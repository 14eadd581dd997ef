"""Gyro bias in integers: the Kalman filter of `..bias` with one variance P for all three axes.

    P ← P + V dt − P² I dt,    b ← b + P I dt · H* e

I = V/σ⁴ is the information a second of a measurement that shall settle at σ: 1 (°/s)⁻² s⁻¹ in motion (σ =
0.1 °/s), 123 at rest (0.03 °/s). In motion two directions of three are seen, and as far as they keep still in
the mean: P shrinks by the share |R̄|²/3 of that.
"""

import numpy as np

from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.smoothing import keep, smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import in_q, product, rounded_shift
from firmware.numerics.fixed.quaternion import rotation_matrix

THREE = np.int32(3)
LARGEST = in_q(2.0 * 3.141592653589793 / 180.0, at.Q_BIAS)
FIRST_VARIANCE = in_q(0.25, at.Q_VARIANCE)
FINE = at.Q_FINE_BIAS - at.Q_BIAS
REST_INFORMATION = in_q(1.0e-4 / 0.03**4, 20)
MOTION_INFORMATION = in_q(1.0, 20)
NOISE = in_q(1.0e-4, 40)
THIRD = in_q(1.0 / 3.0, 30)


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
    gain = _gain(d, REST_INFORMATION)
    for j in range(THREE):
        rate = np.int64(d[at.REST_RATE + 3 + j]) << (at.Q_BIAS - at.Q_RATE)
        _move(d, k, j, gain, _limited(rate - np.int64(d[at.GYRO_BIAS + j])))
    _shrink(d, k, REST_INFORMATION)


@kernel
def learn_in_motion(d, k, n_x, n_y, n_z, north, e_x, e_y, e_z, east):
    """Rows of R̄ for north and east, and the smoothed bias estimate in them."""
    gain = _gain(d, MOTION_INFORMATION)
    bx = np.int64(d[at.GYRO_BIAS])
    by = np.int64(d[at.GYRO_BIAS + 1])
    bz = np.int64(d[at.GYRO_BIAS + 2])
    seen = rounded_shift(n_x * bx + n_y * by + n_z * bz, 30)
    north = _limited(north - np.int64(d[at.LEVEL_RATE]) - seen)
    seen = rounded_shift(e_x * bx + e_y * by + e_z * bz, 30)
    east = _limited(east - np.int64(d[at.LEVEL_RATE + 1]) - seen)
    _move(d, k, 0, gain, rounded_shift(n_x * north + e_x * east, 30))
    _move(d, k, 1, gain, rounded_shift(n_y * north + e_y * east, 30))
    _move(d, k, 2, gain, rounded_shift(n_z * north + e_z * east, 30))
    steady = rounded_shift(n_x * n_x + n_y * n_y + n_z * n_z, 30) + rounded_shift(
        e_x * e_x + e_y * e_y + e_z * e_z, 30
    )
    _shrink(d, k, product(product(steady, THIRD, 30), MOTION_INFORMATION, 30))


@kernel
def forget(d, k):
    """Process noise, up to the variance of the beginning."""
    if d[at.BIAS_VARIANCE] < FIRST_VARIANCE:
        k[at.FINE_VARIANCE] += product(NOISE, np.int64(d[at.PERIOD]), 40 + at.Q_PERIOD - at.Q_FINE_VARIANCE)
        _show_variance(d, k)


@kernel
def _gain(d, information):
    """P I dt in Q32, at most 1."""
    in_a_sample = product(information, np.int64(d[at.PERIOD]), 20 + at.Q_PERIOD - 30)
    gain = product(np.int64(d[at.BIAS_VARIANCE]), in_a_sample, at.Q_VARIANCE + 30 - 32)
    return min(gain, np.int64(1) << 32)


@kernel
def _shrink(d, k, information):
    gain = _gain(d, information)
    less = product(gain, np.int64(d[at.BIAS_VARIANCE]), 32 + at.Q_VARIANCE - at.Q_FINE_VARIANCE)
    k[at.FINE_VARIANCE] = max(k[at.FINE_VARIANCE] - less, np.int64(1))
    _show_variance(d, k)


@kernel
def _show_variance(d, k):
    keep(d, k, at.BIAS_VARIANCE, rounded_shift(k[at.FINE_VARIANCE], at.Q_FINE_VARIANCE - at.Q_VARIANCE))


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
