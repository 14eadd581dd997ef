"""The attitude computer in fixed point: the entry kernels of `..loop`, with `s` an array of int32.

Formats: `.layout`; what they were chosen for: docs/fixed-point.md. Beyond its format a number saturates and
is counted by kind in `i` (layout.SATURATIONS). No floating-point number occurs from the words to the record.
"""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude.burst_words import bridge_over, look_at, note, place_in_ring
from firmware.nav.attitude.fixed import layout as at
from firmware.nav.attitude.fixed.alignment import align
from firmware.nav.attitude.fixed.comparison import by_direction_cosines, by_euler_angles, cross
from firmware.nav.attitude.fixed.earth import rate_of_n, refresh_earth
from firmware.nav.attitude.fixed.motion import move, set_matrix
from firmware.nav.attitude.fixed.samples import look_at_field, shift_ring, write_rates, write_words
from firmware.nav.attitude.fixed.updates import (
    by_rotation_vector,
    by_runge_kutta,
    by_two_samples,
    half_angles,
    set_quaternion,
)
from firmware.nav.attitude.record import write_integers
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.angles import FULL_TURN, HALF_TURN, nanoradians
from firmware.numerics.fixed.arithmetic import product, rounded_shift, saturated
from firmware.numerics.fixed.quaternion import euler_of_quaternion

NANO = 1_000_000_000
MICRO = 1_000_000
THREE = np.int32(3)
REFRESH_MASK = 15
"""The Earth is looked up again every 16 iterations."""
COUNTER = at.SATURATIONS + fl.SATURATED_RATE


@kernel("int64(int32[::1], int64[::1], int64[::1])")
def take_words(s, i, words):
    """Take the 14 words of a burst as they came; returns what was noticed (flags.STALE …).

    Words that cannot be a sample are bridged: the sample before stands for them.
    """
    found = look_at(i, words)
    if found & (fl.NO_ANSWER | fl.SLIPPED) != 0:
        found = bridge_over(i, found)
        shift_ring(s)
    else:
        i[at.BRIDGED_IN_A_ROW] = 0
        shift_ring(s)
        write_words(s, i, words)
        found |= look_at_field(s)
    return _use(s, i, found)


@kernel("int64(int32[::1], int64[::1], int32[::1])")
def take_rates(s, i, sample):
    """Take ω (Q27 rad/s), f (Q22 m/s²) and m (Q41 T), 9 numbers in sensor axes, past all words."""
    i[at.BRIDGED_IN_A_ROW] = 0
    shift_ring(s)
    write_rates(s, i, sample)
    return _use(s, i, look_at_field(s))


@kernel("int64(int32[::1], int64[::1])")
def bridge(s, i):
    """There is no sample at this time: the one before stands for it."""
    shift_ring(s)
    return _use(s, i, bridge_over(i, np.int64(0)))


@kernel
def _use(s, i, found):
    if i[at.MODE] == fl.RUNNING:
        found = place_in_ring(i, found)
    elif found & fl.BRIDGED == 0:
        found = align(s, i, found)
    note(i, found)
    return found


@kernel
def _rate(s, i, k, axis):
    """A rate of the k-th sample less its bias."""
    rate = np.int64(s[at.OMEGA + k + axis]) - np.int64(s[at.GYRO_BIAS + axis])
    return saturated(rate, i, COUNTER)


@kernel
def _column_times(s, c, x, y, z):
    """A column of C_N_B times a rate in Q42, in Q27."""
    total = np.int64(s[c]) * x + np.int64(s[c + 3]) * y + np.int64(s[c + 6]) * z
    return rounded_shift(total, at.Q_UNIT + at.Q_EARTH_RATE - at.Q_RATE)


@kernel("int64(int32[::1], int64[::1])")
def iterate(s, i):
    """One iteration when its three samples are there; returns 1, or 0 when they are not."""
    if i[at.MODE] != fl.RUNNING or i[at.IN_RING] != 3:
        return np.int64(0)
    if i[at.ITERATIONS] & REFRESH_MASK == 0:
        refresh_earth(s, i)
    i[at.ITERATIONS] += 1
    i[at.IN_RING] = 1
    half_period = np.int64(s[at.HALF_PERIOD])
    set_matrix(s, i)
    nn, ne, nd = rate_of_n(s, i)
    ax, ay, az = _rate(s, i, 0, 0), _rate(s, i, 0, 1), _rate(s, i, 0, 2)
    bx, by, bz = _rate(s, i, 3, 0), _rate(s, i, 3, 1), _rate(s, i, 3, 2)
    cx, cy, cz = _rate(s, i, 6, 0), _rate(s, i, 6, 1), _rate(s, i, 6, 2)
    px, py, pz, qx, qy, qz = half_angles(half_period, i, ax, ay, az, bx, by, bz, cx, cy, cz)
    move(s, i, nn, ne, nd, px, py, pz, qx, qy, qz)
    # ω_in in body axes at t, t + T/2 and t + T
    c = at.C_N_B
    ux = _column_times(s, c, nn, ne, nd)
    uy = _column_times(s, c + 1, nn, ne, nd)
    uz = _column_times(s, c + 2, nn, ne, nd)
    vx, vy, vz = cross(px, py, pz, ux, uy, uz, 32)
    wx, wy, wz = cross(px + qx, py + qy, pz + qz, ux, uy, uz, 32)
    _turn(
        s,
        i,
        ax - ux,
        ay - uy,
        az - uz,
        bx - (ux - vx),
        by - (uy - vy),
        bz - (uz - vz),
        cx - (ux - wx),
        cy - (uy - wy),
        cz - (uz - wz),
    )
    return np.int64(1)


@kernel
def _turn(s, i, ax, ay, az, bx, by, bz, cx, cy, cz):
    """QUATERNION after an iteration with rates ω_nb."""
    half_period = np.int64(s[at.HALF_PERIOD])
    method = i[at.METHOD]
    w = np.int64(s[at.QUATERNION])
    x = np.int64(s[at.QUATERNION + 1])
    y = np.int64(s[at.QUATERNION + 2])
    z = np.int64(s[at.QUATERNION + 3])
    if method == fl.RK4:
        w, x, y, z = by_runge_kutta(half_period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz)
    elif method == fl.EULER_ANGLES:
        w, x, y, z = by_euler_angles(s, i, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz)
    elif method == fl.DIRECTION_COSINES:
        w, x, y, z = by_direction_cosines(half_period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz)
    else:
        px, py, pz, qx, qy, qz = half_angles(half_period, i, ax, ay, az, bx, by, bz, cx, cy, cz)
        if method == fl.TWO_SAMPLE:
            w, x, y, z = by_two_samples(w, x, y, z, px, py, pz, qx, qy, qz)
        else:
            w, x, y, z = by_rotation_vector(method, w, x, y, z, px + qx, py + qy, pz + qz)
    set_quaternion(s, i, w, x, y, z)


@kernel("void(int32[::1], int64[::1], int64[::1])")
def solution(s, i, out):
    """Fill the record (layout.OUT_…) and forget what was noticed before."""
    q = at.QUATERNION
    yaw, pitch, roll = euler_of_quaternion(
        np.int64(s[q]), np.int64(s[q + 1]), np.int64(s[q + 2]), np.int64(s[q + 3])
    )
    out[at.OUT_YAW] = nanoradians(yaw + FULL_TURN if yaw < 0 else yaw)
    out[at.OUT_PITCH] = nanoradians(pitch)
    out[at.OUT_ROLL] = nanoradians(np.int64(HALF_TURN) if roll == -HALF_TURN else roll)
    for k in range(THREE):
        rate = np.int64(s[at.OMEGA + at.NEWEST + k]) - np.int64(s[at.GYRO_BIAS + k])
        out[at.OUT_RATE + k] = product(rate, NANO, at.Q_RATE)
        out[at.OUT_VELOCITY + k] = product(np.int64(s[at.VELOCITY + k]), MICRO, at.Q_VELOCITY)
        out[at.OUT_GYRO_BIAS + k] = product(np.int64(s[at.GYRO_BIAS + k]), NANO, at.Q_RATE)
    for k in range(np.int32(4)):
        out[at.OUT_QUATERNION + k] = product(np.int64(s[q + k]), NANO, at.Q_UNIT)
    write_integers(i, out)
