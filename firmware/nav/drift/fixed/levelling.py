"""Levelling (`..levelling`) in integers.

The short way from u to (0, 0, −1) is turned by the quaternion (c, −u_y/2c, u_x/2c, 0), c² = (1 − u_z)/2.
"""

import numpy as np

from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.smoothing import grown, keep, smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import ONE_Q30
from firmware.numerics.fixed.arithmetic import in_q, limited, product, rounded_shift
from firmware.numerics.fixed.quaternion import quaternion_product, rotation_matrix, to_length_one
from firmware.numerics.fixed.roots import quotient, square_root

LARGEST_FORCE = in_q(160.0, at.Q_FORCE)
WEIGHTLESS = in_q(0.5, at.Q_FORCE)
LARGEST_RATE = in_q(0.1, at.Q_BIAS)
UPSIDE_DOWN = in_q(1.0e-6, at.Q_UNIT)


@kernel
def rotated(w, x, y, z, vx, vy, vz):
    """q ⊗ v ⊗ q* of a unit quaternion; |v| < 2³¹."""
    c = rotation_matrix(w, x, y, z)
    return (
        rounded_shift(c[0] * vx + c[1] * vy + c[2] * vz, 30),
        rounded_shift(c[3] * vx + c[4] * vy + c[5] * vz, 30),
        rounded_shift(c[6] * vx + c[7] * vy + c[8] * vz, 30),
    )


@kernel
def quaternion_at(d, place):
    """Four components."""
    return np.int64(d[place]), np.int64(d[place + 1]), np.int64(d[place + 2]), np.int64(d[place + 3])


@kernel
def keep_quaternion(d, k, place, w, x, y, z):
    """Store a quaternion whose length is near 1, with length 1."""
    w, x, y, z = to_length_one(w, x, y, z)
    keep(d, k, place, w)
    keep(d, k, place + 1, x)
    keep(d, k, place + 2, y)
    keep(d, k, place + 3, z)


@kernel
def _within(rate):
    """A rate of levelling is of use up to 2 °/s; at the beginning it is any."""
    return min(max(rate, np.int64(-LARGEST_RATE)), np.int64(LARGEST_RATE))


@kernel
def level(d, k, fx, fy, fz):
    """Turn the level frame by a specific force, body axes. Returns the sample's weight in the mean."""
    weight = grown(k, at.FORCE_AGE, at.SETTLED)
    w, x, y, z = quaternion_at(d, at.Q_FREE)
    counter = at.SATURATIONS
    fx = limited(fx, np.int64(LARGEST_FORCE), k, counter)
    fy = limited(fy, np.int64(LARGEST_FORCE), k, counter)
    fz = limited(fz, np.int64(LARGEST_FORCE), k, counter)
    fx, fy, fz = rotated(w, x, y, z, fx, fy, fz)
    fx = smooth(d, k, at.FORCE, 3, at.FORCE_GAIN, weight, fx)
    fy = smooth(d, k, at.FORCE + 1, 3, at.FORCE_GAIN, weight, fy)
    fz = smooth(d, k, at.FORCE + 2, 3, at.FORCE_GAIN, weight, fz)
    d[at.LEVEL_RATE] = 0
    d[at.LEVEL_RATE + 1] = 0
    length = square_root(fx * fx + fy * fy + fz * fz)
    if length <= WEIGHTLESS:
        return weight
    w, x, y, z = quaternion_at(d, at.Q_LEVEL)
    ux, uy, uz = rotated(
        w, x, y, z, quotient(fx, length, 30), quotient(fy, length, 30), quotient(fz, length, 30)
    )
    if ONE_Q30 - uz > UPSIDE_DOWN:
        cw = square_root((ONE_Q30 - uz) << 29)
        cx = quotient(-uy, 2 * cw, 30)
        cy = quotient(ux, 2 * cw, 30)
        per_period = np.int64(d[at.PER_PERIOD])
        bits = at.Q_UNIT + at.Q_PER_PERIOD - at.Q_BIAS
        d[at.LEVEL_RATE] = np.int32(_within(product(-uy, per_period, bits)))
        d[at.LEVEL_RATE + 1] = np.int32(_within(product(ux, per_period, bits)))
    else:
        cw = np.int64(0)
        cx = np.int64(ONE_Q30)
        cy = np.int64(0)
    w, x, y, z = quaternion_product(cw, cx, cy, np.int64(0), w, x, y, z, 30)
    keep_quaternion(d, k, at.Q_LEVEL, w, x, y, z)
    return weight
