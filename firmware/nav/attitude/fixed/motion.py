"""Velocity and position in fixed point; the formulas are those of `..motion`.

Velocity in Q21 m/s, specific force in Q22 m/s², increments of velocity in Q27, distances of an iteration in
Q26 m. Latitude and longitude are 2⁻⁴⁰ rad and height is 2⁻²⁰ m. What an iteration leaves over (2⁻²⁷ m/s,
2⁻⁶⁰ rad, 2⁻²⁶ m) is carried to the next, so that no rounding adds up in velocity and position.
"""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude.fixed import layout as at
from firmware.nav.attitude.fixed.comparison import cross
from firmware.nav.attitude.fixed.samples import store
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import product, rounded_shift, saturated
from firmware.numerics.fixed.quaternion import rotation_matrix
from firmware.numerics.fixed_position import stop_at_pole, wrap_longitude

COUNTER = at.SATURATIONS + fl.SATURATED_VELOCITY
REST_BITS = at.Q_REST - 40
HEIGHT_REST_BITS = at.Q_DISTANCE - 20
Q_TURN = 46
"""Angle of an iteration between n and the Earth, rad."""


@kernel
def set_matrix(s, i):
    """C_N_B of QUATERNION."""
    q = at.QUATERNION
    c = at.C_N_B
    kind = fl.SATURATED_ATTITUDE
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = rotation_matrix(
        np.int64(s[q]), np.int64(s[q + 1]), np.int64(s[q + 2]), np.int64(s[q + 3])
    )
    store(s, i, c, kind, c00)
    store(s, i, c + 1, kind, c01)
    store(s, i, c + 2, kind, c02)
    store(s, i, c + 3, kind, c10)
    store(s, i, c + 4, kind, c11)
    store(s, i, c + 5, kind, c12)
    store(s, i, c + 6, kind, c20)
    store(s, i, c + 7, kind, c21)
    store(s, i, c + 8, kind, c22)


@kernel
def turned_force(s, k, ax, ay, az):
    """The k-th specific force in the body axes before the turn α (Q32)."""
    fx = np.int64(s[at.FORCE + k])
    fy = np.int64(s[at.FORCE + k + 1])
    fz = np.int64(s[at.FORCE + k + 2])
    ux, uy, uz = cross(ax, ay, az, fx, fy, fz, 33)
    ux, uy, uz = cross(ax, ay, az, fx + ux, fy + uy, fz + uz, 32)
    return fx + ux, fy + uy, fz + uz


@kernel
def increment(s, i, k, middle, end):
    """∫f dt of one component by Simpson's rule, in Q27."""
    total = np.int64(s[at.FORCE + k]) + 4 * middle + end
    shift = at.Q_FORCE + at.Q_SIXTH_PERIOD - at.Q_INCREMENT
    return saturated(product(total, np.int64(s[at.SIXTH_PERIOD]), shift), i, COUNTER)


@kernel
def row_times(s, c, x, y, z):
    """A row of C_N_B times a vector."""
    return rounded_shift(np.int64(s[c]) * x + np.int64(s[c + 1]) * y + np.int64(s[c + 2]) * z, 30)


@kernel
def small_turn(s, rate):
    """Angle in Q46 of an iteration at a rate in Q42."""
    return product(rate, np.int64(s[at.PERIOD]), at.Q_EARTH_RATE + at.Q_PERIOD - Q_TURN)


@kernel
def new_velocity(s, i, k, change):
    """Store a component changed by `change` (Q27); returns twice its mean over the iteration."""
    before = np.int64(s[at.VELOCITY + k])
    bits = at.Q_INCREMENT - at.Q_VELOCITY
    total = i[at.VELOCITY_REST + k] + change
    whole = rounded_shift(total, bits)
    i[at.VELOCITY_REST + k] = total - (whole << bits)
    store(s, i, at.VELOCITY + k, fl.SATURATED_VELOCITY, before + whole)
    return before + np.int64(s[at.VELOCITY + k])


@kernel
def move(s, i, nn, ne, nd, px, py, pz, qx, qy, qz):
    """Velocity and position over an iteration with ω_in^n (Q42) and the angles p and q of its two halves."""
    bx, by, bz = turned_force(s, 3, px, py, pz)
    cx, cy, cz = turned_force(s, 6, px + qx, py + qy, pz + qz)
    ux = increment(s, i, 0, bx, cx)
    uy = increment(s, i, 1, by, cy)
    uz = increment(s, i, 2, bz, cz)
    un = row_times(s, at.C_N_B, ux, uy, uz)
    ue = row_times(s, at.C_N_B + 3, ux, uy, uz)
    ud = row_times(s, at.C_N_B + 6, ux, uy, uz)
    fall = product(np.int64(s[at.GRAVITY]), np.int64(s[at.PERIOD]), at.Q_PERIOD)
    # velocity in the middle of the iteration, Q21
    half = at.Q_INCREMENT - at.Q_VELOCITY + 1
    mn = np.int64(s[at.VELOCITY]) + rounded_shift(un, half)
    me = np.int64(s[at.VELOCITY + 1]) + rounded_shift(ue, half)
    md = np.int64(s[at.VELOCITY + 2]) + rounded_shift(ud + fall, half)
    kn, ke, kd = cross(
        small_turn(s, np.int64(s[at.EARTH_RATE_N]) + nn),
        small_turn(s, ne),
        small_turn(s, np.int64(s[at.EARTH_RATE_D]) + nd),
        mn,
        me,
        md,
        Q_TURN + at.Q_VELOCITY - at.Q_INCREMENT,
    )
    # half the turn of n while the force acted
    tn, te, td = cross(small_turn(s, nn), small_turn(s, ne), small_turn(s, nd), un, ue, ud, Q_TURN + 1)
    change_position(
        s,
        i,
        new_velocity(s, i, 0, un - kn - tn),
        new_velocity(s, i, 1, ue - ke - te),
        new_velocity(s, i, 2, ud + fall - kd - td),
    )


@kernel
def distance(s, twice_mean):
    """Metres of an iteration in Q26 at twice a mean velocity in Q21."""
    return product(twice_mean, np.int64(s[at.HALF_PERIOD]), at.Q_VELOCITY + at.Q_HALF_PERIOD - at.Q_DISTANCE)


@kernel
def change_position(s, i, north, east, down):
    """Move by an iteration at twice these mean velocities."""
    turn = product(
        distance(s, north),
        np.int64(s[at.PER_MERIDIAN_RADIUS]),
        at.Q_DISTANCE + at.Q_PER_RADIUS - at.Q_REST,
    )
    i[at.LATITUDE] = stop_at_pole(i[at.LATITUDE] + whole_units(i, 0, turn, REST_BITS))
    turn = product(distance(s, east), np.int64(s[at.PER_NORMAL_RADIUS]), 33)
    turn = product(turn, np.int64(s[at.PER_COS_LATITUDE]), 6)
    i[at.LONGITUDE] = wrap_longitude(i[at.LONGITUDE] + whole_units(i, 1, turn, REST_BITS))
    i[at.HEIGHT] += whole_units(i, 2, -distance(s, down), HEIGHT_REST_BITS)


@kernel
def whole_units(i, k, change, bits):
    """Whole units of a change together with what was left over; the new rest is kept."""
    total = i[at.FIXED_REST + k] + change
    whole = rounded_shift(total, bits)
    i[at.FIXED_REST + k] = total - (whole << bits)
    return whole
