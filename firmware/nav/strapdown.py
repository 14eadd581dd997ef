"""Strapdown: attitude, velocity and position from one sample to the next.

Full rate (`two_sample`): rates and forces are integrated by the trapezoid; with α, v the increments of this
interval and α₁, v₁ those of the one before,

    rotation     φ = α + α₁ × α / 12                                      coning
    velocity     u = v + α × v / 2 + (α₁ × v + v₁ × α) / 12               rotation, sculling

(P. Savage, Strapdown inertial navigation integration algorithm design, JGCD 21 (1998), eqs. 57 and 56 of
parts 1 and 2, in the form that uses the preceding increments.) With `two_sample` off, the samples are means
over the interval and φ = ω T, u = f T, as in the source thesis, eqs. 2.13 and 2.22.

    q_nb ← q_nb ⊗ q(φ − C_n_bᵀ ω_in T)
    v    ← v + C_n_b u + (g − (2 ω_ie + ω_en) × v) T
    L, λ, h by the trapezoid of v

Latitude and longitude are integers of 2⁻⁴⁰ rad; the height carries what its float32 cannot hold.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import add_to_latitude, add_to_longitude
from firmware.numerics.quaternion import quaternion_of_rotation, quaternion_product, rotation_matrix

HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE_HALVES = np.float32(1.5)
TWELFTH = np.float32(1.0 / 12.0)


@kernel
def advance_between_samples(f, i, dt, wx, wy, wz, ax, ay, az):
    """One interval whose ends are the sample before and this one: (rad/s, m/s²) in body axes, compensated."""
    h = HALF * dt
    tx = h * (f[at.OMEGA_B] + wx)
    ty = h * (f[at.OMEGA_B + 1] + wy)
    tz = h * (f[at.OMEGA_B + 2] + wz)
    vx = h * (f[at.FORCE_B] + ax)
    vy = h * (f[at.FORCE_B + 1] + ay)
    vz = h * (f[at.FORCE_B + 2] + az)
    px = f[at.DELTA_ANGLE]
    py = f[at.DELTA_ANGLE + 1]
    pz = f[at.DELTA_ANGLE + 2]
    ux = f[at.DELTA_VELOCITY]
    uy = f[at.DELTA_VELOCITY + 1]
    uz = f[at.DELTA_VELOCITY + 2]
    f[at.DELTA_ANGLE] = tx
    f[at.DELTA_ANGLE + 1] = ty
    f[at.DELTA_ANGLE + 2] = tz
    f[at.DELTA_VELOCITY] = vx
    f[at.DELTA_VELOCITY + 1] = vy
    f[at.DELTA_VELOCITY + 2] = vz
    # α + α₁/6 and v + v₁/6 fold the rotation and the sculling terms into two cross products
    sx = HALF * tx + TWELFTH * px
    sy = HALF * ty + TWELFTH * py
    sz = HALF * tz + TWELFTH * pz
    _advance(
        f,
        i,
        dt,
        tx + TWELFTH * (py * tz - pz * ty),
        ty + TWELFTH * (pz * tx - px * tz),
        tz + TWELFTH * (px * ty - py * tx),
        vx + (sy * vz - sz * vy) + TWELFTH * (uy * tz - uz * ty),
        vy + (sz * vx - sx * vz) + TWELFTH * (uz * tx - ux * tz),
        vz + (sx * vy - sy * vx) + TWELFTH * (ux * ty - uy * tx),
    )


@kernel
def advance_by_mean(f, i, dt, wx, wy, wz, ax, ay, az):
    """One interval over which the sample is the mean: the one-sample algorithm."""
    _advance(f, i, dt, wx * dt, wy * dt, wz * dt, ax * dt, ay * dt, az * dt)


@kernel
def _advance(f, i, dt, rx, ry, rz, ux, uy, uz):
    c00 = f[at.C_N_B]
    c01 = f[at.C_N_B + 1]
    c02 = f[at.C_N_B + 2]
    c10 = f[at.C_N_B + 3]
    c11 = f[at.C_N_B + 4]
    c12 = f[at.C_N_B + 5]
    c20 = f[at.C_N_B + 6]
    c21 = f[at.C_N_B + 7]
    c22 = f[at.C_N_B + 8]
    vn = f[at.VELOCITY]
    ve = f[at.VELOCITY + 1]
    vd = f[at.VELOCITY + 2]
    ie_n = f[at.EARTH_RATE_N]
    ie_d = f[at.EARTH_RATE_D]
    en_n = ve * f[at.PER_NORMAL_RADIUS]
    en_e = -vn * f[at.PER_MERIDIAN_RADIUS]
    en_d = -en_n * f[at.TAN_LATITUDE]

    # velocity
    kn = TWO * ie_n + en_n
    kd = TWO * ie_d + en_d
    nn = vn + (c00 * ux + c01 * uy + c02 * uz) - (en_e * vd - kd * ve) * dt
    ne = ve + (c10 * ux + c11 * uy + c12 * uz) - (kd * vn - kn * vd) * dt
    nd = vd + (c20 * ux + c21 * uy + c22 * uz) + (f[at.GRAVITY] - (kn * ve - en_e * vn)) * dt
    f[at.VELOCITY] = nn
    f[at.VELOCITY + 1] = ne
    f[at.VELOCITY + 2] = nd
    move(f, i, HALF * (vn + nn) * dt, HALF * (ve + ne) * dt, HALF * (vd + nd) * dt)

    # attitude
    zn = (ie_n + en_n) * dt
    ze = en_e * dt
    zd = (ie_d + en_d) * dt
    bw, bx, by, bz = quaternion_of_rotation(
        rx - (c00 * zn + c10 * ze + c20 * zd),
        ry - (c01 * zn + c11 * ze + c21 * zd),
        rz - (c02 * zn + c12 * ze + c22 * zd),
    )
    w, x, y, z = quaternion_product(
        f[at.QUATERNION], f[at.QUATERNION + 1], f[at.QUATERNION + 2], f[at.QUATERNION + 3], bw, bx, by, bz
    )
    set_attitude(f, w, x, y, z)


@kernel
def set_attitude(f, w, x, y, z):
    """Take q_nb, whose length is 1 but for rounding (one Newton step mends that), and its matrix."""
    scale = THREE_HALVES - HALF * (w * w + x * x + y * y + z * z)
    w *= scale
    x *= scale
    y *= scale
    z *= scale
    f[at.QUATERNION] = w
    f[at.QUATERNION + 1] = x
    f[at.QUATERNION + 2] = y
    f[at.QUATERNION + 3] = z
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = rotation_matrix(w, x, y, z)
    f[at.C_N_B] = c00
    f[at.C_N_B + 1] = c01
    f[at.C_N_B + 2] = c02
    f[at.C_N_B + 3] = c10
    f[at.C_N_B + 4] = c11
    f[at.C_N_B + 5] = c12
    f[at.C_N_B + 6] = c20
    f[at.C_N_B + 7] = c21
    f[at.C_N_B + 8] = c22


@kernel
def move(f, i, north, east, down):
    """Move the position by so many metres."""
    i[at.LATITUDE] = add_to_latitude(i[at.LATITUDE], north * f[at.PER_MERIDIAN_RADIUS])
    i[at.LONGITUDE] = add_to_longitude(
        i[at.LONGITUDE], east * f[at.PER_NORMAL_RADIUS] * f[at.PER_COS_LATITUDE]
    )
    rest = f[at.HEIGHT_REST] - down
    height = f[at.HEIGHT] + rest
    f[at.HEIGHT_REST] = rest - (height - f[at.HEIGHT])
    f[at.HEIGHT] = height
