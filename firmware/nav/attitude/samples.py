"""From a burst of the sensor to the three samples of an iteration."""

import math

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.burst_words import ACCEL, GYRO, MAGN, signed_14
from firmware.numerics.dialect import kernel

THREE = np.int32(3)
SIX = np.int32(6)


@kernel
def shift_ring(s):
    """Make room for a sample; until it is written, the one before stands for it too."""
    for k in range(SIX):
        s[at.OMEGA + k] = s[at.OMEGA + k + 3]
        s[at.FORCE + k] = s[at.FORCE + k + 3]


@kernel
def count(words, k):
    """The k-th output in counts."""
    return np.float32(np.int32(signed_14(words[k])))


@kernel
def mounted(s, place, x, y, z):
    """Three values in sensor axes written to `place` in body axes."""
    m = at.C_B_S
    for k in range(THREE):
        s[place + k] = s[m + 3 * k] * x + s[m + 3 * k + 1] * y + s[m + 3 * k + 2] * z


@kernel
def write_words(s, words):
    """The outputs of a burst as the newest sample."""
    g = s[at.GYRO_SCALE]
    a = s[at.ACCEL_SCALE]
    m = s[at.FIELD_SCALE]
    mounted(
        s,
        at.OMEGA + at.NEWEST,
        g * count(words, GYRO),
        g * count(words, GYRO + 1),
        g * count(words, GYRO + 2),
    )
    mounted(
        s,
        at.FORCE + at.NEWEST,
        a * count(words, ACCEL) - s[at.ACCEL_BIAS],
        a * count(words, ACCEL + 1) - s[at.ACCEL_BIAS + 1],
        a * count(words, ACCEL + 2) - s[at.ACCEL_BIAS + 2],
    )
    mounted(s, at.FIELD, m * count(words, MAGN), m * count(words, MAGN + 1), m * count(words, MAGN + 2))


@kernel
def write_rates(s, sample):
    """ω, f and m (9) as the newest sample."""
    mounted(s, at.OMEGA + at.NEWEST, sample[0], sample[1], sample[2])
    mounted(
        s,
        at.FORCE + at.NEWEST,
        sample[3] - s[at.ACCEL_BIAS],
        sample[4] - s[at.ACCEL_BIAS + 1],
        sample[5] - s[at.ACCEL_BIAS + 2],
    )
    mounted(s, at.FIELD, sample[6], sample[7], sample[8])


@kernel
def look_at_field(s):
    """FIELD_IMPLAUSIBLE when the newest field cannot be the Earth's, else 0."""
    x = s[at.FIELD]
    y = s[at.FIELD + 1]
    z = s[at.FIELD + 2]
    strength = np.float32(math.sqrt(x * x + y * y + z * z))
    if strength >= s[at.LEAST_FIELD] and strength <= s[at.MOST_FIELD]:
        return np.int64(0)
    return np.int64(fl.FIELD_IMPLAUSIBLE)
