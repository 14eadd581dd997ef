"""The drift compensation of a sensor that is fed directly: the door `step`; the loop's is in `correction`.

    q_nb = R_z(heading) ⊗ q_level ⊗ q_free

Gyros turn the free frame, Δθ = (ω_k − b) dt + Δθ_{k−1} × Δθ_k / 12 (coning: Titterton & Weston, ch. 11);
accelerometers turn the level frame, the magnetometer the heading. Inputs that are no numbers, intervals that
cannot be, and saturated rates are counted, flagged and bridged; without a magnetometer (zeros or NaN) the
heading is that of the gyros. After

    D. Laidig, T. Seel: VQF: Highly accurate IMU orientation estimation with bias estimation and magnetic
    disturbance rejection. Information Fusion 91 (2023) 187-204, doi:10.1016/j.inffus.2022.10.014,

with the time constants and limits published there. Added to it: forms that keep their digits in float32, any
sample interval, a heading gain that follows the quality of gyros and field (`heading`), and what becomes of
angles that were lost (`losing`, `rates`).
"""

import numpy as np

from firmware.nav.drift import layout as at
from firmware.nav.drift.bias import (
    forget,
    learn_at_rest,
    learn_in_motion,
    vertical_variance,
    watch_motion,
)
from firmware.nav.drift.heading import FIELD_TAU, take_field
from firmware.nav.drift.levelling import TAU as FORCE_TAU
from firmware.nav.drift.levelling import level
from firmware.nav.drift.rates import is_usable, take_rate
from firmware.nav.drift.resting import TAU as REST_TAU
from firmware.nav.drift.resting import watch_forces, watch_rates
from firmware.nav.drift.smoothing import coefficients
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import (
    normalise_quaternion,
    quaternion_of_rotation,
    quaternion_product,
    rotate_vector,
    rotate_vector_back,
)
from firmware.numerics.trigonometry import sine_cosine

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWELFTH = np.float32(1.0 / 12.0)
LARGEST_FORCE = np.float32(4000.0)
SMALLEST_FORCE = np.float32(1.0e-3)
LARGEST_FIELD = np.float32(1.0e6)
SHORTEST_INTERVAL = np.float32(1.0e-5)
LONGEST_INTERVAL = np.float32(1000.0)
LARGEST_TURN_SQUARE = np.float32(100.0**2)
"""rad²: over an interval in which a rate would turn farther, it tells nothing of the attitude."""
GAP_INTERVALS = np.float32(5.0)
SHORTEST_GAP = np.float32(0.02)
USUAL_SHARE = np.float32(0.02)


@kernel("void(float32[::1], int64[::1], float32[::1])")
def step(d, k, sample):
    """Take a sample (layout.SAMPLE_…): s since the last one, rad/s, m/s², field in any unit; body axes.

    The attitude is in Q_NB, flags in k[FLAGS]."""
    dt = sample[at.SAMPLE_DT]
    if not begin(d, k, dt):
        return
    w = at.SAMPLE_OMEGA
    px = d[at.RATE]
    py = d[at.RATE + 1]
    pz = d[at.RATE + 2]
    gap = is_gap(k)
    x, y, z = take_rate(d, k, dt, gap, sample[w], sample[w + 1], sample[w + 2])
    if gap:
        forget(d, dt)
    wx = d[at.RATE]
    wy = d[at.RATE + 1]
    wz = d[at.RATE + 2]
    coning = ZERO if gap else TWELFTH * dt * dt
    turn_free(
        d,
        (wx - d[at.GYRO_BIAS]) * dt + coning * (py * wz - pz * wy) + x,
        (wy - d[at.GYRO_BIAS + 1]) * dt + coning * (pz * wx - px * wz) + y,
        (wz - d[at.GYRO_BIAS + 2]) * dt + coning * (px * wy - py * wx) + z,
    )
    f = at.SAMPLE_FORCE
    m = at.SAMPLE_FIELD
    fuse(d, k, d[at.DT], sample[f], sample[f + 1], sample[f + 2], sample[m], sample[m + 1], sample[m + 2])


@kernel
def begin(d, k, dt):
    """Flags and coefficients of a sample; False when its interval cannot be.

    DT becomes the time that the sample is worth: after a gap it is one of many, not the mean of all."""
    k[at.FLAGS] = 0
    if not (dt >= SHORTEST_INTERVAL and dt <= LONGEST_INTERVAL):
        k[at.BAD_INTERVALS] += 1
        return False
    usual = d[at.USUAL_DT]
    if usual == ZERO:
        d[at.USUAL_DT] = dt
    elif dt > GAP_INTERVALS * usual and dt > SHORTEST_GAP:
        k[at.FLAGS] |= at.GAP
        k[at.GAPS] += 1
        d[at.USUAL_DT] = usual + USUAL_SHARE * (GAP_INTERVALS - ONE) * usual
        dt = usual
    else:
        d[at.USUAL_DT] = usual + USUAL_SHARE * (dt - usual)
    if dt != d[at.DT]:
        d[at.DT] = dt
        _set_gain(d, at.FORCE_GAIN, dt, FORCE_TAU)
        _set_gain(d, at.REST_GAIN, dt, REST_TAU)
        _set_gain(d, at.FIELD_GAIN, dt, FIELD_TAU)
    return True


@kernel
def is_gap(k):
    """Whether the last samples before this one are missing."""
    return (k[at.FLAGS] & at.GAP) != 0


@kernel
def _set_gain(d, gain, dt, tau):
    g, inverse = coefficients(dt, tau)
    d[gain] = g
    d[gain + 1] = inverse


@kernel
def turn_free(d, x, y, z):
    """Turn the body in the free frame by the rotation vector (x, y, z), body axes."""
    if not x * x + y * y + z * z <= LARGEST_TURN_SQUARE:
        return
    qw, qx, qy, qz = quaternion_of_rotation(x, y, z)
    q = at.Q_FREE
    w, x, y, z = quaternion_product(d[q], d[q + 1], d[q + 2], d[q + 3], qw, qx, qy, qz)
    w, x, y, z = normalise_quaternion(w, x, y, z)
    d[q] = w
    d[q + 1] = x
    d[q + 2] = y
    d[q + 3] = z


@kernel
def fuse(d, k, dt, fx, fy, fz, mx, my, mz):
    """Level, learn the bias, correct the heading, after the free frame was turned."""
    if k[at.FLAGS] & (at.NO_RATE | at.GAP):
        d[at.REST_TIME] = ZERO
    else:
        watch_rates(d, dt, d[at.RATE], d[at.RATE + 1], d[at.RATE + 2])
    d[at.BIAS_PAUSE] = max(d[at.BIAS_PAUSE] - dt, ZERO)
    if is_usable(fx, fy, fz, LARGEST_FORCE) and fx * fx + fy * fy + fz * fz > SMALLEST_FORCE:
        _take_force(d, k, dt, fx, fy, fz)
    else:
        k[at.BAD_FORCES] += 1
        k[at.FLAGS] |= at.NO_FORCE
        d[at.REST_TIME] = ZERO
    w, x, y, z = _level_attitude(d)
    if is_usable(mx, my, mz, LARGEST_FIELD) and (mx != ZERO or my != ZERO or mz != ZERO):
        ux, uy, uz = rotate_vector_back(w, x, y, z, ZERO, ZERO, ONE)
        mx, my, mz = rotate_vector(w, x, y, z, mx, my, mz)
        take_field(d, k, dt, mx, my, mz, vertical_variance(d, ux, uy, uz))
    else:
        k[at.MISSING_FIELDS] += 1
        k[at.FLAGS] |= at.FIELD_MISSING
    if d[at.FORCE_AGE] < FORCE_TAU:
        k[at.FLAGS] |= at.REGAINING
    k[at.SAMPLES] += 1
    _compose(d, w, x, y, z)


@kernel
def _take_force(d, k, dt, fx, fy, fz):
    rests = watch_forces(d, dt, fx, fy, fz)
    weight = level(d, dt, fx, fy, fz)
    w, x, y, z = _level_attitude(d)
    n_x, n_y, n_z, north, e_x, e_y, e_z, east = watch_motion(d, weight, w, x, y, z)
    forget(d, dt)
    if rests:
        k[at.FLAGS] |= at.AT_REST
        learn_at_rest(d, dt)
    elif d[at.BIAS_PAUSE] == ZERO and not is_gap(k):
        learn_in_motion(d, dt, n_x, n_y, n_z, north, e_x, e_y, e_z, east)


@kernel
def _level_attitude(d):
    """Body to the level frame."""
    p = at.Q_LEVEL
    q = at.Q_FREE
    return quaternion_product(d[p], d[p + 1], d[p + 2], d[p + 3], d[q], d[q + 1], d[q + 2], d[q + 3])


@kernel
def _compose(d, w, x, y, z):
    """Q_NB of the attitude in the level frame, GYRO_DELAY ahead of the rates."""
    s, c = sine_cosine(HALF * d[at.HEADING])
    w, x, y, z = quaternion_product(c, ZERO, ZERO, s, w, x, y, z)
    delay = d[at.GYRO_DELAY]
    if delay > ZERO:
        aw, ax, ay, az = quaternion_of_rotation(
            (d[at.RATE] - d[at.GYRO_BIAS]) * delay,
            (d[at.RATE + 1] - d[at.GYRO_BIAS + 1]) * delay,
            (d[at.RATE + 2] - d[at.GYRO_BIAS + 2]) * delay,
        )
        w, x, y, z = quaternion_product(w, x, y, z, aw, ax, ay, az)
    w, x, y, z = normalise_quaternion(w, x, y, z)
    d[at.Q_NB] = w
    d[at.Q_NB + 1] = x
    d[at.Q_NB + 2] = y
    d[at.Q_NB + 3] = z
