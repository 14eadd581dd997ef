"""The attitude computer: entry kernels in float32; `numerics.precision.load` gives them in float64.

    configure → (take_words or take_rates) twice → iterate → solution → …

A sample every T/2; the sample at the end of an iteration begins the next one too. While aligning the samples
are summed up (alignment.py), then `iterate` carries attitude (updates.py), velocity and position (motion.py)
over each iteration. Rates are those relative to n,

    ω_nb = ω_ib − b − C_n_bᵀ (ω_ie + ω_en)                                                 (source, 2-12)

with C_n_bᵀ ω_in followed through the iteration: it turns with −ω × in body axes.
"""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.alignment import align
from firmware.nav.attitude.burst_words import bridge_over, look_at, note, place_in_ring
from firmware.nav.attitude.comparison import by_direction_cosines, by_euler_angles, cross
from firmware.nav.attitude.motion import move, rate_of_n, refresh_earth, set_matrix
from firmware.nav.attitude.record import write_integers
from firmware.nav.attitude.samples import look_at_field, shift_ring, write_rates, write_words
from firmware.nav.attitude.updates import by_rotation_vector, by_runge_kutta, by_two_samples, half_angles
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import euler_of_quaternion
from firmware.numerics.wide_integers import int64_of_float32

NANO = np.float32(1.0e9)
MICRO = np.float32(1.0e6)
THREE = np.int32(3)
REFRESH_MASK = 15
"""The Earth is looked up again every 16 iterations."""


@kernel("int64(float32[::1], int64[::1], int64[::1])")
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
        write_words(s, words)
        found |= look_at_field(s)
    return _use(s, i, found)


@kernel("int64(float32[::1], int64[::1], float32[::1])")
def take_rates(s, i, sample):
    """Take ω (rad/s), f (m/s²) and m (T), 9 numbers in sensor axes, past all words."""
    i[at.BRIDGED_IN_A_ROW] = 0
    shift_ring(s)
    write_rates(s, sample)
    return _use(s, i, look_at_field(s))


@kernel("int64(float32[::1], int64[::1])")
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


@kernel("int64(float32[::1], int64[::1])")
def iterate(s, i):
    """One iteration when its three samples are there; returns 1, or 0 when they are not."""
    if i[at.MODE] != fl.RUNNING or i[at.IN_RING] != 3:
        return np.int64(0)
    if i[at.ITERATIONS] & REFRESH_MASK == 0:
        refresh_earth(s, i)
    i[at.ITERATIONS] += 1
    i[at.IN_RING] = 1
    period = s[at.PERIOD]
    set_matrix(s)
    nn, ne, nd = rate_of_n(s)
    o = at.OMEGA
    b = at.GYRO_BIAS
    ax, ay, az = s[o] - s[b], s[o + 1] - s[b + 1], s[o + 2] - s[b + 2]
    bx, by, bz = s[o + 3] - s[b], s[o + 4] - s[b + 1], s[o + 5] - s[b + 2]
    cx, cy, cz = s[o + 6] - s[b], s[o + 7] - s[b + 1], s[o + 8] - s[b + 2]
    px, py, pz, qx, qy, qz = half_angles(period, ax, ay, az, bx, by, bz, cx, cy, cz)
    move(s, i, nn, ne, nd, px, py, pz, qx, qy, qz)
    # ω_in in body axes at t, t + T/2 and t + T
    c = at.C_N_B
    ux = s[c] * nn + s[c + 3] * ne + s[c + 6] * nd
    uy = s[c + 1] * nn + s[c + 4] * ne + s[c + 7] * nd
    uz = s[c + 2] * nn + s[c + 5] * ne + s[c + 8] * nd
    vx, vy, vz = cross(px, py, pz, ux, uy, uz)
    wx, wy, wz = cross(px + qx, py + qy, pz + qz, ux, uy, uz)
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
    period = s[at.PERIOD]
    method = i[at.METHOD]
    w = s[at.QUATERNION]
    x = s[at.QUATERNION + 1]
    y = s[at.QUATERNION + 2]
    z = s[at.QUATERNION + 3]
    if method == fl.RK4:
        w, x, y, z = by_runge_kutta(period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz)
    elif method == fl.EULER_ANGLES:
        w, x, y, z = by_euler_angles(period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz)
    elif method == fl.DIRECTION_COSINES:
        w, x, y, z = by_direction_cosines(period, w, x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz)
    else:
        px, py, pz, qx, qy, qz = half_angles(period, ax, ay, az, bx, by, bz, cx, cy, cz)
        if method == fl.TWO_SAMPLE:
            w, x, y, z = by_two_samples(w, x, y, z, px, py, pz, qx, qy, qz)
        else:
            w, x, y, z = by_rotation_vector(method, w, x, y, z, px + qx, py + qy, pz + qz)
    s[at.QUATERNION] = w
    s[at.QUATERNION + 1] = x
    s[at.QUATERNION + 2] = y
    s[at.QUATERNION + 3] = z


@kernel("void(float32[::1], int64[::1], int64[::1])")
def solution(s, i, out):
    """Fill the record (layout.OUT_…) and forget what was noticed before."""
    q = at.QUATERNION
    yaw, pitch, roll = euler_of_quaternion(s[q], s[q + 1], s[q + 2], s[q + 3])
    out[at.OUT_YAW] = int64_of_float32(yaw * NANO)
    out[at.OUT_PITCH] = int64_of_float32(pitch * NANO)
    out[at.OUT_ROLL] = int64_of_float32(roll * NANO)
    for k in range(THREE):
        rate = s[at.OMEGA + at.NEWEST + k] - s[at.GYRO_BIAS + k]
        out[at.OUT_RATE + k] = int64_of_float32(rate * NANO)
        out[at.OUT_VELOCITY + k] = int64_of_float32(s[at.VELOCITY + k] * MICRO)
        out[at.OUT_GYRO_BIAS + k] = int64_of_float32(s[at.GYRO_BIAS + k] * NANO)
    for k in range(np.int32(4)):
        out[at.OUT_QUATERNION + k] = int64_of_float32(s[q + k] * NANO)
    write_integers(i, out)
