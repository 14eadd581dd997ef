"""The drift compensation in fixed point: `step` of `..fusion` for a constant sample period.

A sample is nine integers: ω (Q25 rad/s), f (Q22 m/s²), m (Q41 T); MISSING is a value that is none. Gains,
limits and structure are those of the float filter; it differs in two things: a missing rate is held without
looking back (`losing` has what may be wrong by that), and after saturation levelling and heading are
regained without bridging the peak.
"""

import numpy as np

from firmware.nav.attitude.fixed.updates import by_rotation_vector
from firmware.nav.drift import layout as flag
from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.bias import (
    forget,
    learn_at_rest,
    learn_in_motion,
    vertical_variance,
    watch_motion,
)
from firmware.nav.drift.fixed.heading import take_field
from firmware.nav.drift.fixed.levelling import keep_quaternion, level, quaternion_at, rotated
from firmware.nav.drift.fixed.losing import lose, lose_all, unknown_turn
from firmware.nav.drift.fixed.smoothing import grown, keep, smooth
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import sine_cosine
from firmware.numerics.fixed.arithmetic import in_q, limited, product, rounded_shift
from firmware.numerics.fixed.quaternion import quaternion_product, rotation_matrix

THREE = np.int32(3)
TWELFTH = in_q(1.0 / 12.0, 31)
LARGEST_TURN = in_q(0.4, at.Q_TURN)
LARGEST_FIELD = in_q(4.9e-4, at.Q_FIELD)
SMALLEST_FORCE = in_q(0.03, at.Q_FORCE)
STILL_RATE = in_q((2.0 * 3.141592653589793 / 180.0) ** 2, 40)
STILL_FORCE = in_q(0.25, 24)
LARGEST_BIAS = in_q(2.0 * 3.141592653589793 / 180.0, at.Q_RATE)
LARGEST_DEVIATION = 1 << 29


@kernel("void(int32[::1], int64[::1], int32[::1])")
def step(d, k, sample):
    """Take a sample; the attitude is in Q_NB, flags in k[FLAGS]."""
    k[at.FLAGS] = 0
    take_rates(d, k, sample[0], sample[1], sample[2])
    px = np.int64(d[at.TURN])
    py = np.int64(d[at.TURN + 1])
    pz = np.int64(d[at.TURN + 2])
    x = _turn(d, k, 0)
    y = _turn(d, k, 1)
    z = _turn(d, k, 2)
    turn_free(
        d,
        k,
        x + product(rounded_shift(py * z - pz * y, 32), TWELFTH, 31),
        y + product(rounded_shift(pz * x - px * z, 32), TWELFTH, 31),
        z + product(rounded_shift(px * y - py * x, 32), TWELFTH, 31),
    )
    fuse(d, k, sample[3], sample[4], sample[5], sample[6], sample[7], sample[8])


@kernel
def take_rates(d, k, x, y, z):
    """RATE and its flags from rates that may be missing."""
    if x == at.MISSING or y == at.MISSING or z == at.MISSING:
        k[at.FLAGS] |= flag.NO_RATE
        k[flag.BAD_RATES] += 1
        k[at.MISSING_TIME] += 1
        if k[at.MISSING_TIME] > k[at.LONGEST_MISSING]:
            lose_all(k)
        return
    if k[at.MISSING_TIME] > 0 and k[at.SAMPLES] > 0:
        lose(d, k, unknown_turn(d, k, np.int64(x), np.int64(y), np.int64(z)))
    k[at.MISSING_TIME] = 0
    d[at.RATE] = x
    d[at.RATE + 1] = y
    d[at.RATE + 2] = z
    limit = np.int64(d[at.RATE_LIMIT])
    if limit > 0 and max(max(abs(np.int64(x)), abs(np.int64(y))), abs(np.int64(z))) >= limit:
        k[at.FLAGS] |= flag.SATURATED
        k[at.SATURATED_SAMPLES] += 1
        lose_all(k)


@kernel
def _turn(d, k, axis):
    """ω dt less the bias, Q32; kept for the coning of the next sample."""
    period = np.int64(d[at.PERIOD])
    turn = product(np.int64(d[at.RATE + axis]), period, at.Q_RATE + at.Q_PERIOD - at.Q_TURN)
    turn -= product(np.int64(d[at.GYRO_BIAS + axis]), period, at.Q_BIAS + at.Q_PERIOD - at.Q_TURN)
    turn = limited(turn, np.int64(LARGEST_TURN), k, at.SATURATIONS)
    keep(d, k, at.TURN + axis, turn)
    return turn


@kernel
def turn_free(d, k, x, y, z):
    """Turn the body in the free frame by a rotation vector in Q32."""
    qw, qx, qy, qz = quaternion_at(d, at.Q_FREE)
    qw, qx, qy, qz = by_rotation_vector(4, qw, qx, qy, qz, x, y, z)
    keep_quaternion(
        d,
        k,
        at.Q_FREE,
        rounded_shift(qw, 8),
        rounded_shift(qx, 8),
        rounded_shift(qy, 8),
        rounded_shift(qz, 8),
    )


@kernel
def fuse(d, k, fx, fy, fz, mx, my, mz):
    """Level, learn the bias, correct the heading, after the free frame was turned."""
    weight = grown(k, at.REST_AGE, at.SETTLED + 1)
    if k[at.FLAGS] & flag.NO_RATE != 0:
        k[at.REST_TIME] = 0
    else:
        _watch_rates(d, k, weight)
    k[at.BIAS_PAUSE] = max(k[at.BIAS_PAUSE] - 1, np.int64(0))
    fx, fy, fz = np.int64(fx), np.int64(fy), np.int64(fz)
    if fx == at.MISSING or fy == at.MISSING or fz == at.MISSING or _is_small(fx, fy, fz):
        k[at.BAD_FORCES] += 1
        k[at.FLAGS] |= flag.NO_FORCE
        k[at.REST_TIME] = 0
    else:
        _take_force(d, k, weight, fx, fy, fz)
    w, x, y, z = level_attitude(d)
    mx, my, mz = np.int64(mx), np.int64(my), np.int64(mz)
    if max(max(abs(mx), abs(my)), abs(mz)) <= LARGEST_FIELD and (mx != 0 or my != 0 or mz != 0):
        c = rotation_matrix(w, x, y, z)
        keep(d, k, at.BIAS_VARIANCE, vertical_variance(k, c[6], c[7], c[8]))
        mx, my, mz = rotated(w, x, y, z, mx, my, mz)
        take_field(d, k, rounded_shift(mx, 1), rounded_shift(my, 1), rounded_shift(mz, 1))
    else:
        k[at.MISSING_FIELDS] += 1
        k[at.FLAGS] |= flag.FIELD_MISSING
    if k[at.FORCE_AGE] < k[at.SETTLED]:
        k[at.FLAGS] |= flag.REGAINING
    k[at.SAMPLES] += 1
    s, c = sine_cosine(rounded_shift(np.int64(d[at.HEADING]), 1))
    w, x, y, z = quaternion_product(c, np.int64(0), np.int64(0), s, w, x, y, z, 30)
    keep_quaternion(d, k, at.Q_NB, w, x, y, z)


@kernel
def _is_small(x, y, z):
    return max(max(abs(x), abs(y)), abs(z)) < SMALLEST_FORCE


@kernel
def level_attitude(d):
    """Body to the level frame."""
    aw, ax, ay, az = quaternion_at(d, at.Q_LEVEL)
    bw, bx, by, bz = quaternion_at(d, at.Q_FREE)
    return quaternion_product(aw, ax, ay, az, bw, bx, by, bz, 30)


@kernel
def _watch_rates(d, k, weight):
    """Rest: rates stay close to their smoothed values, which are no turn."""
    squares = np.int64(0)
    largest = np.int64(0)
    for j in range(THREE):
        rate = np.int64(d[at.RATE + j])
        apart = rate - smooth(d, k, at.REST_RATE + j, 3, at.REST_GAIN, weight, rate)
        apart = min(max(apart, np.int64(-LARGEST_DEVIATION)), np.int64(LARGEST_DEVIATION))
        squares += rounded_shift(apart * apart, 10)
        largest = max(largest, abs(np.int64(d[at.REST_RATE + 3 + j])))
    if squares >= STILL_RATE or largest > LARGEST_BIAS:
        k[at.REST_TIME] = 0


@kernel
def _take_force(d, k, weight, fx, fy, fz):
    squares = _apart(d, k, 0, weight, fx) + _apart(d, k, 1, weight, fy) + _apart(d, k, 2, weight, fz)
    k[at.REST_TIME] = 0 if squares >= STILL_FORCE else k[at.REST_TIME] + 1
    weight = level(d, k, fx, fy, fz)
    w, x, y, z = level_attitude(d)
    n_x, n_y, n_z, north, e_x, e_y, e_z, east = watch_motion(d, k, weight, w, x, y, z)
    forget(d, k)
    if k[at.REST_TIME] >= k[at.REST_AFTER]:
        k[at.FLAGS] |= flag.AT_REST
        learn_at_rest(d, k)
    elif k[at.BIAS_PAUSE] == 0:
        learn_in_motion(d, k, n_x, n_y, n_z, north, e_x, e_y, e_z, east)


@kernel
def _apart(d, k, axis, weight, force):
    """Square of a force's distance from its smoothed value, Q24."""
    apart = force - smooth(d, k, at.REST_FORCE + axis, 3, at.REST_GAIN, weight, force)
    apart = min(max(apart, np.int64(-LARGEST_DEVIATION)), np.int64(LARGEST_DEVIATION))
    return rounded_shift(apart * apart, 20)
