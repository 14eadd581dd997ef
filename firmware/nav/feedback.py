"""Closed loop: the estimated error goes into the state, and the filter's own error estimate back to zero.

    r += δr    v += δv    q_nb ← q(φ) ⊗ q_nb    parameters += theirs

After a large rotation φ̂ the attitude error is counted from another attitude (attitude_reset). At rest the
error of the accelerometer bias is counted in the axes in which rest began, C_f, as the error model has it
(prediction): b_a += C_n_bᵀ C_f δb_a.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav.attitude_reset import turn_attitude_error
from firmware.nav.history import log_correction
from firmware.nav.prediction import begin_interval
from firmware.nav.strapdown import move, set_attitude
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import quaternion_of_rotation, quaternion_product

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
N = np.int32(at.STATES)
LARGE_ROTATION_SQUARE = np.float32(0.02 * 0.02)
LARGEST = np.float32(1.0e7)


@kernel
def clear_correction(f):
    """Nothing estimated yet."""
    for j in range(N):
        f[at.CORRECTION + j] = ZERO


@kernel
def correction_is_sound(f):
    """Whether every estimated error is finite."""
    total = ZERO
    for j in range(N):
        total += abs(f[at.CORRECTION + j])
    return total < LARGEST


@kernel
def feed_back(f, i):
    """Apply layout.CORRECTION to the state; call right after a prediction of the covariance."""
    c = at.CORRECTION
    log_correction(f, i)
    move(f, i, f[c], f[c + 1], f[c + 2])
    for k in range(np.int32(3)):
        f[at.VELOCITY + k] += f[c + at.X_VELOCITY + k]
    px = f[c + at.X_ATTITUDE]
    py = f[c + at.X_ATTITUDE + 1]
    pz = f[c + at.X_ATTITUDE + 2]
    bw, bx, by, bz = quaternion_of_rotation(px, py, pz)
    w, x, y, z = quaternion_product(
        bw, bx, by, bz, f[at.QUATERNION], f[at.QUATERNION + 1], f[at.QUATERNION + 2], f[at.QUATERNION + 3]
    )
    set_attitude(f, w, x, y, z)
    if f[at.AT_REST] != ZERO:
        _turn_accelerometer_correction(f)
    for k in range(np.int32(at.PARAMETERS)):
        f[at.GYRO_BIAS + k] += f[c + at.X_GYRO_BIAS + k]
    if px * px + py * py + pz * pz > LARGE_ROTATION_SQUARE:
        turn_attitude_error(f, HALF * px, HALF * py, HALF * pz)
    begin_interval(f)


@kernel
def _turn_accelerometer_correction(f):
    """From the axes of the error model to those of the present attitude."""
    a = at.SINCE_C_N_B
    b = at.C_N_B
    d = at.CORRECTION + at.X_ACCEL_BIAS
    north = f[a] * f[d] + f[a + 1] * f[d + 1] + f[a + 2] * f[d + 2]
    east = f[a + 3] * f[d] + f[a + 4] * f[d + 1] + f[a + 5] * f[d + 2]
    down = f[a + 6] * f[d] + f[a + 7] * f[d + 1] + f[a + 8] * f[d + 2]
    for k in range(np.int32(3)):
        f[d + k] = f[b + k] * north + f[b + 3 + k] * east + f[b + 6 + k] * down
