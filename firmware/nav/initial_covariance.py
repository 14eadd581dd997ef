"""How sure navigation is at its beginning.

Levelling reads the tilt from the specific force, so that a bias of the accelerometers shows as tilt exactly:
with f_n = (0, 0, −g),  φ_N = (C δb_a)_E / g,  φ_E = −(C δb_a)_N / g. Position starts with the receiver's own
correlated error; yaw from a course has the error of the mounting yaw. In P = U D Uᵀ each of these is one
entry of U above the parameter's D.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.covariance import clear
from firmware.nav.gnss_noise import position_variances, speed_variance
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import rotation_matrix

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
THREE = np.int32(3)
AGE_VARIANCE = np.float32(0.1)
"""(m/s)² per s²: what an unknown acceleration makes of the velocity while the fix ages."""


@kernel
def begin_covariance(f, e, age, tilt_variance, yaw_variance, gyro_variance):
    """P of a state begun with epoch `e`, `age` s old: see the module for what is correlated."""
    clear(f)
    horizontal, vertical = position_variances(f, e)
    speed = speed_variance(f, e) + age * age * AGE_VARIANCE
    for k in range(THREE):
        correlated = f[cfg.POSITION_ERROR_VARIANCE_V] if k == 2 else f[cfg.POSITION_ERROR_VARIANCE_H]
        f[at.D + at.X_POSITION + k] = vertical if k == 2 else horizontal
        if f[cfg.POSITION_ERROR_WEIGHT] != ZERO:
            f[at.D + at.X_POSITION + k] += correlated
            correlated = ZERO
        f[at.U + (at.X_GNSS_ERROR + k) * at.STATES + at.X_POSITION + k] = -ONE
        f[at.D + at.X_VELOCITY + k] = speed
        f[at.D + at.X_ATTITUDE + k] = yaw_variance if k == 2 else tilt_variance
        f[at.D + at.X_GYRO_BIAS + k] = gyro_variance
        f[at.D + at.X_ACCEL_BIAS + k] = f[cfg.ACCEL_BIAS_VARIANCE]
        f[at.D + at.X_GNSS_ERROR + k] = correlated
        f[at.D + at.X_GYRO_INSTABILITY + k] = f[cfg.GYRO_INSTABILITY_VARIANCE]
        f[at.D + at.X_GYRO_PER_KELVIN + k] = f[cfg.GYRO_PER_KELVIN_VARIANCE]
        response = f[cfg.SCALE_VARIANCE] if k == 2 else f[cfg.MISALIGNMENT_VARIANCE]
        f[at.D + at.X_YAW_RESPONSE + k] = response
        response = f[cfg.SCALE_VARIANCE] if k == 0 else f[cfg.MISALIGNMENT_VARIANCE]
        f[at.D + at.X_FORCE_RESPONSE + k] = response
        response = f[cfg.SCALE_VARIANCE] if k == 1 else f[cfg.MISALIGNMENT_VARIANCE]
        f[at.D + at.X_FORCE_RESPONSE + 3 + k] = response
    f[at.D + at.X_MOUNTING] = f[cfg.MOUNTING_VARIANCE]
    f[at.D + at.X_MOUNTING + 1] = f[cfg.MOUNTING_VARIANCE]
    f[at.D + at.X_LATENCY] = f[cfg.LATENCY_VARIANCE]


@kernel
def correlate_tilt(f, w, x, y, z):
    """Tilt was read from the specific force at attitude (w, x, y, z): tie it to the accelerometer bias."""
    c00, c01, c02, c10, c11, c12, _, _, _ = rotation_matrix(w, x, y, z)
    per_g = ONE / f[at.GRAVITY]
    _tie_tilt(f, 0, c00 * per_g, c10 * per_g)
    _tie_tilt(f, 1, c01 * per_g, c11 * per_g)
    _tie_tilt(f, 2, c02 * per_g, c12 * per_g)


@kernel
def _tie_tilt(f, axis, north, east):
    column = at.U + (at.X_ACCEL_BIAS + axis) * at.STATES
    f[column + at.X_ATTITUDE] = east
    f[column + at.X_ATTITUDE + 1] = -north


@kernel
def correlate_yaw(f):
    """Yaw was read from the course: tie it to the mounting yaw."""
    f[at.U + at.X_MOUNTING * at.STATES + at.X_ATTITUDE + 2] = -ONE
