"""Velocity and position (source, 2-58 … 2-60), in north-east-down on WGS-84.

    v̇ = C_n_b f_b − (2 ω_ie + ω_en) × v + g        φ̇ = v_N / (R_M + h)     λ̇ = v_E / ((R_N + h) cos φ)

The specific forces at t, t + T/2 and t + T are turned into the body axes at t by the angles turned so far,
R(α) f = f + α × f + ½ α × (α × f), and summed by Simpson's rule, so that rotation and sculling within the
iteration count. The Coriolis terms are taken at the middle of the iteration. Positions are integers.
"""

import numpy as np

from firmware.nav.attitude import layout as at
from firmware.nav.earth import EARTH_RATE, LEAST_COS, earth_at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import radians_of_units, stop_at_pole, wrap_longitude
from firmware.numerics.quaternion import rotation_matrix
from firmware.numerics.trigonometry import sine_cosine
from firmware.numerics.wide_integers import float32_of_int64, int64_of_float32

HALF = np.float32(0.5)
TWO = np.float32(2.0)
FOUR = np.float32(4.0)
SIXTH = np.float32(1.0 / 6.0)
UNITS_PER_RADIAN = np.float32(2.0**40)
UNITS_PER_METRE = np.float32(2.0**20)
METRES_PER_UNIT = np.float32(2.0**-20)


@kernel
def refresh_earth(s, i):
    """Earth rate, curvature and gravity at the present position."""
    sin_lat, cos_lat = sine_cosine(radians_of_units(i[at.LATITUDE]))
    cos_lat = max(cos_lat, LEAST_COS)
    height = float32_of_int64(i[at.HEIGHT]) * METRES_PER_UNIT
    _, _, per_meridian, per_normal, tangent, per_cos, gravity = earth_at(sin_lat, cos_lat, height)
    s[at.EARTH_RATE_N] = EARTH_RATE * cos_lat
    s[at.EARTH_RATE_D] = -EARTH_RATE * sin_lat
    s[at.PER_MERIDIAN_RADIUS] = per_meridian
    s[at.PER_NORMAL_RADIUS] = per_normal
    s[at.TAN_LATITUDE] = tangent
    s[at.PER_COS_LATITUDE] = per_cos
    s[at.GRAVITY] = gravity


@kernel
def set_matrix(s):
    """C_N_B of QUATERNION."""
    q = at.QUATERNION
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = rotation_matrix(s[q], s[q + 1], s[q + 2], s[q + 3])
    c = at.C_N_B
    s[c], s[c + 1], s[c + 2] = c00, c01, c02
    s[c + 3], s[c + 4], s[c + 5] = c10, c11, c12
    s[c + 6], s[c + 7], s[c + 8] = c20, c21, c22


@kernel
def rate_of_n(s):
    """ω_in^n north, east, down: the Earth's rate and that of moving over it, (2-13) and (2-14) in NED."""
    en_n = s[at.VELOCITY + 1] * s[at.PER_NORMAL_RADIUS]
    en_e = -s[at.VELOCITY] * s[at.PER_MERIDIAN_RADIUS]
    return s[at.EARTH_RATE_N] + en_n, en_e, s[at.EARTH_RATE_D] - en_n * s[at.TAN_LATITUDE]


@kernel
def turned_force(s, k, ax, ay, az):
    """The k-th specific force in the body axes before the turn α."""
    fx = s[at.FORCE + k]
    fy = s[at.FORCE + k + 1]
    fz = s[at.FORCE + k + 2]
    ux = fx + HALF * (ay * fz - az * fy)
    uy = fy + HALF * (az * fx - ax * fz)
    uz = fz + HALF * (ax * fy - ay * fx)
    return fx + (ay * uz - az * uy), fy + (az * ux - ax * uz), fz + (ax * uy - ay * ux)


@kernel
def move(s, i, nn, ne, nd, px, py, pz, qx, qy, qz):
    """Velocity and position over an iteration with ω_in^n and the angles p and q of its two halves.

    C_N_B still is that of t.
    """
    period = s[at.PERIOD]
    bx, by, bz = turned_force(s, 3, px, py, pz)
    cx, cy, cz = turned_force(s, 6, px + qx, py + qy, pz + qz)
    t = SIXTH * period
    ux = t * (s[at.FORCE] + FOUR * bx + cx)
    uy = t * (s[at.FORCE + 1] + FOUR * by + cy)
    uz = t * (s[at.FORCE + 2] + FOUR * bz + cz)
    c = at.C_N_B
    un = s[c] * ux + s[c + 1] * uy + s[c + 2] * uz
    ue = s[c + 3] * ux + s[c + 4] * uy + s[c + 5] * uz
    ud = s[c + 6] * ux + s[c + 7] * uy + s[c + 8] * uz
    fall = s[at.GRAVITY] * period
    vn = s[at.VELOCITY]
    ve = s[at.VELOCITY + 1]
    vd = s[at.VELOCITY + 2]
    # middle of the iteration
    mn = vn + HALF * un
    me = ve + HALF * ue
    md = vd + HALF * (ud + fall)
    kn = period * (s[at.EARTH_RATE_N] + nn)
    ke = period * ne
    kd = period * (s[at.EARTH_RATE_D] + nd)
    h = HALF * period
    wn = vn + un - (ke * md - kd * me) - h * (ne * ud - nd * ue)
    we = ve + ue - (kd * mn - kn * md) - h * (nd * un - nn * ud)
    wd = vd + (ud + fall) - (kn * me - ke * mn) - h * (nn * ue - ne * un)
    s[at.VELOCITY] = wn
    s[at.VELOCITY + 1] = we
    s[at.VELOCITY + 2] = wd
    change_position(s, i, h * (vn + wn), h * (ve + we), h * (vd + wd))


@kernel
def change_position(s, i, north, east, down):
    """Move by so many metres; what is less than a unit waits for the next time."""
    rest = s[at.LATITUDE_REST] + north * s[at.PER_MERIDIAN_RADIUS] * UNITS_PER_RADIAN
    whole = int64_of_float32(rest)
    s[at.LATITUDE_REST] = rest - float32_of_int64(whole)
    i[at.LATITUDE] = stop_at_pole(i[at.LATITUDE] + whole)
    east = east * s[at.PER_NORMAL_RADIUS] * s[at.PER_COS_LATITUDE]
    rest = s[at.LONGITUDE_REST] + east * UNITS_PER_RADIAN
    whole = int64_of_float32(rest)
    s[at.LONGITUDE_REST] = rest - float32_of_int64(whole)
    i[at.LONGITUDE] = wrap_longitude(i[at.LONGITUDE] + whole)
    rest = s[at.HEIGHT_REST] - down * UNITS_PER_METRE
    whole = int64_of_float32(rest)
    s[at.HEIGHT_REST] = rest - float32_of_int64(whole)
    i[at.HEIGHT] += whole
