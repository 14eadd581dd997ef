"""Level by the accelerometers: accelerations of motion average out where the axes do not turn.

The specific force is turned into the free frame, smoothed there (τ = 3 s), turned on into the level frame and
normalised to u. At rest it points up, so the level frame is turned the short way from u to (0, 0, −1):

    Δq = (1 − u_z, −u_y, u_x, 0)/|…|,      q_level ← Δq ⊗ q_level        (Laidig & Seel 2023)

What remains of gyro bias shows as the rate of this turn.
"""

import math

import numpy as np

from firmware.nav.drift import layout as at
from firmware.nav.drift.smoothing import grown, smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import normalise_quaternion, quaternion_product, rotate_vector

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TAU = np.float32(3.0)
WEIGHTLESS = np.float32(0.5)
"""m/s²: a smoothed force of less has no direction."""
UPSIDE_DOWN = np.float32(1.0e-6)


@kernel
def level(d, dt, fx, fy, fz):
    """Turn the level frame by a specific force, body axes; Q_FREE is that of its sample.

    Returns the weight of this sample in the mean, 0 past that.
    """
    weight = grown(d, at.FORCE_AGE, dt, TAU)
    q = at.Q_FREE
    x, y, z = rotate_vector(d[q], d[q + 1], d[q + 2], d[q + 3], fx, fy, fz)
    x = smooth(d, at.FORCE, 3, at.FORCE_GAIN, weight, x)
    y = smooth(d, at.FORCE + 1, 3, at.FORCE_GAIN, weight, y)
    z = smooth(d, at.FORCE + 2, 3, at.FORCE_GAIN, weight, z)
    d[at.LEVEL_RATE] = ZERO
    d[at.LEVEL_RATE + 1] = ZERO
    length = np.float32(math.sqrt(x * x + y * y + z * z))
    if not length > WEIGHTLESS:
        return weight
    q = at.Q_LEVEL
    ux, uy, uz = rotate_vector(d[q], d[q + 1], d[q + 2], d[q + 3], x / length, y / length, z / length)
    if ONE - uz > UPSIDE_DOWN:
        cw, cx, cy, cz = normalise_quaternion(ONE - uz, -uy, ux, ZERO)
        d[at.LEVEL_RATE] = -uy / dt
        d[at.LEVEL_RATE + 1] = ux / dt
    else:
        cw, cx, cy, cz = ZERO, ONE, ZERO, ZERO
    w, x, y, z = quaternion_product(cw, cx, cy, cz, d[q], d[q + 1], d[q + 2], d[q + 3])
    w, x, y, z = normalise_quaternion(w, x, y, z)
    d[q] = w
    d[q + 1] = x
    d[q + 2] = y
    d[q + 3] = z
    return weight
