"""From a burst of the sensor to the three samples of an iteration, in fixed point."""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude.burst_words import ACCEL, GYRO, MAGN, signed_14
from firmware.nav.attitude.fixed import layout as at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import product, rounded_shift, saturated
from firmware.numerics.fixed.roots import square_root

THREE = np.int32(3)
SIX = np.int32(6)
FIELD_SHIFT = 8
"""Off the field before it is squared."""


@kernel
def shift_ring(s):
    """Make room for a sample; until it is written, the one before stands for it too."""
    for k in range(SIX):
        s[at.OMEGA + k] = s[at.OMEGA + k + 3]
        s[at.FORCE + k] = s[at.FORCE + k + 3]


@kernel
def store(s, i, place, kind, value):
    """Keep a number; beyond 32 bits it saturates and is counted under `kind`."""
    s[place] = np.int32(saturated(value, i, at.SATURATIONS + kind))


@kernel
def mounted(s, i, place, kind, x, y, z):
    """Three values in sensor axes written to `place` in body axes."""
    for k in range(THREE):
        m = at.C_B_S + 3 * k
        total = np.int64(s[m]) * x + np.int64(s[m + 1]) * y + np.int64(s[m + 2]) * z
        store(s, i, place + k, kind, rounded_shift(total, 30))


@kernel
def count(s, words, k, scale):
    """The k-th output in its unit."""
    return product(signed_14(words[k]), np.int64(s[scale]), at.SCALE_SHIFT)


@kernel
def write_words(s, i, words):
    """The outputs of a burst as the newest sample."""
    write_sample(
        s,
        i,
        count(s, words, GYRO, at.GYRO_SCALE),
        count(s, words, GYRO + 1, at.GYRO_SCALE),
        count(s, words, GYRO + 2, at.GYRO_SCALE),
        count(s, words, ACCEL, at.ACCEL_SCALE),
        count(s, words, ACCEL + 1, at.ACCEL_SCALE),
        count(s, words, ACCEL + 2, at.ACCEL_SCALE),
        count(s, words, MAGN, at.FIELD_SCALE),
        count(s, words, MAGN + 1, at.FIELD_SCALE),
        count(s, words, MAGN + 2, at.FIELD_SCALE),
    )


@kernel
def write_rates(s, i, sample):
    """ω, f and m (9) as the newest sample."""
    write_sample(
        s,
        i,
        np.int64(sample[0]),
        np.int64(sample[1]),
        np.int64(sample[2]),
        np.int64(sample[3]),
        np.int64(sample[4]),
        np.int64(sample[5]),
        np.int64(sample[6]),
        np.int64(sample[7]),
        np.int64(sample[8]),
    )


@kernel
def write_sample(s, i, wx, wy, wz, fx, fy, fz, mx, my, mz):
    """The newest sample from values in sensor axes."""
    mounted(s, i, at.OMEGA + at.NEWEST, fl.SATURATED_RATE, wx, wy, wz)
    b = at.ACCEL_BIAS
    fx -= np.int64(s[b])
    fy -= np.int64(s[b + 1])
    fz -= np.int64(s[b + 2])
    mounted(s, i, at.FORCE + at.NEWEST, fl.SATURATED_FORCE, fx, fy, fz)
    mounted(s, i, at.FIELD, fl.SATURATED_FIELD, mx, my, mz)


@kernel
def look_at_field(s):
    """FIELD_IMPLAUSIBLE when the newest field cannot be the Earth's, else 0."""
    square = np.int64(0)
    for k in range(THREE):
        part = np.int64(s[at.FIELD + k]) >> FIELD_SHIFT
        square += part * part
    strength = square_root(square) << FIELD_SHIFT
    if strength >= np.int64(s[at.LEAST_FIELD]) and strength <= np.int64(s[at.MOST_FIELD]):
        return np.int64(0)
    return np.int64(fl.FIELD_IMPLAUSIBLE)
