"""Exact kinematics of the vehicle at any instant: what a perfect inertial sensor at its origin feels.

The path gives speed v, yaw ψ, pitch θ, roll φ as piecewise analytic functions. The velocity lies along the
path's own axis x (plus vibration u, in path axes), the body may sway about it:

    v_n  = C_n_p w,  w = (v + u_x, u_y, u_z);   v̇_n = C_n_p (ẇ + ω_np × w)
    C_n_b = Rz(ψ + ψ_s) Ry(θ + θ_s) Rx(φ + φ_s) R(ρ),   ρ = α (cos Ωt, sin Ωt, 0) the coning vector
    ω_ib = ω_nb + C_b_n (ω_ie + ω_en)
    f_b  = C_b_n (v̇_n + (2 ω_ie + ω_en) × v_n − g_n)

that is the strapdown mechanization of source 002 (eqs. 2-24 … 2-28, 3-23 … 3-32) solved for what the sensors
measure. Angular acceleration ω̇_ib is exact but for the change of the Earth's radii with time.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import inner
from host.sim.earth import EARTH_RATE, gravity, radii
from host.sim.sine import TWO_PI, sincos, sincos_turns
from host.sim.trajectory.tables import (
    CONE_ANGLE,
    CONE_FREQUENCY,
    HALF_SPEED_SQUARED,
    SHAKE_ALWAYS,
    MotionTables,
)

LATITUDE, LONGITUDE, HEIGHT = 0, 1, 2
VELOCITY = 3
C_NB = 6
OMEGA_IB = 15
FORCE = 18
OMEGA_DOT = 21
ROW = 24
"""Columns of a row of truth: lat, lon, h, v_n(3), C_n_b(9, by rows), ω_ib_b(3), f_b(3), ω̇_ib_b(3)."""

CHANNELS = 4
SPEED, YAW, PITCH, ROLL = range(4)
SWAY_ROLL, SWAY_PITCH, SWAY_YAW, SHAKE_X, SHAKE_Y, SHAKE_Z = range(6)


@inner
def find_pieces(tables: MotionTables, t_ns: int, row: NDArray[np.int64]) -> None:
    """Move the channels' current rows forward (or back) to the pieces that hold `t_ns`."""
    for channel in range(CHANNELS):
        k = row[channel]
        while k + 1 < tables.first[channel + 1] and tables.start_ns[k + 1] <= t_ns:
            k += 1
        while k > tables.first[channel] and tables.start_ns[k] > t_ns:
            k -= 1
        row[channel] = k


@inner
def channel_value(c: NDArray[np.float64], tau: float) -> tuple[float, float, float]:
    """Value, first and second derivative of one piece."""
    x = c[7]
    d = 0.0
    e = 0.0
    for k in range(6, -1, -1):
        e = e * tau + d
        d = d * tau + x
        x = x * tau + c[k]
    if c[20] == 0.0:
        return x, d, 2.0 * e
    w = c[20]
    s, s1, s2 = c[13], 0.0, 0.0
    q, q1, q2 = c[19], 0.0, 0.0
    for k in range(4, -1, -1):
        s2 = s2 * tau + s1
        s1 = s1 * tau + s
        s = s * tau + c[8 + k]
        q2 = q2 * tau + q1
        q1 = q1 * tau + q
        q = q * tau + c[14 + k]
    sin, cos = sincos(w * tau)
    x += s * sin + q * cos
    d += (s1 - w * q) * sin + (q1 + w * s) * cos
    e2 = (2.0 * s2 - 2.0 * w * q1 - w * w * s) * sin + (2.0 * q2 + 2.0 * w * s1 - w * w * q) * cos
    return x, d, 2.0 * e + e2


@inner
def channel(
    tables: MotionTables, row: NDArray[np.int64], index: int, t_ns: int
) -> tuple[float, float, float]:
    """Value and two derivatives of a channel whose current piece is known."""
    k = row[index]
    return channel_value(tables.coefficients[k], (t_ns - tables.start_ns[k]) * 1e-9)


@inner
def envelope(tables: MotionTables, v: float, v1: float, v2: float) -> tuple[float, float, float]:
    """Size of the shaking at a speed, and its derivatives with respect to time."""
    if tables.constants[SHAKE_ALWAYS] != 0.0:
        return 1.0, 0.0, 0.0
    half = tables.constants[HALF_SPEED_SQUARED]
    x = v * v
    r = 1.0 / (x + half)
    first = 2.0 * v * half * r * r
    second = 2.0 * half * (half - 3.0 * x) * r * r * r
    return x * r, first * v1, second * v1 * v1 + first * v2


@inner
def shaking(tables: MotionTables, t_ns: int, waves: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Sums of the bank at `t_ns`: out (6, 3) = value and two derivatives per target; `waves` is scratch."""
    bank = tables.bank
    t = t_ns * 1e-9
    count = bank.shape[1]
    for i in range(count):
        waves[0, i], waves[1, i] = sincos_turns(bank[0, i] * t + bank[1, i])
    for target in range(6):
        value, first, second = 0.0, 0.0, 0.0
        for i in range(tables.bank_limits[target], tables.bank_limits[target + 1]):
            w = TWO_PI * bank[0, i]
            s = bank[2, i] * waves[0, i]
            value += s
            first += w * (bank[2, i] * waves[1, i])
            second -= w * (w * s)
        out[target, 0] = value
        out[target, 1] = first
        out[target, 2] = second


@inner
def path_velocity(
    tables: MotionTables, row: NDArray[np.int64], t_ns: int, scratch: NDArray[np.float64]
) -> tuple[float, float, float]:
    """v_n alone, for the integration of the position."""
    v, v1, v2 = channel(tables, row, SPEED, t_ns)
    yaw, _, _ = channel(tables, row, YAW, t_ns)
    pitch, _, _ = channel(tables, row, PITCH, t_ns)
    sy, cy = sincos(yaw)
    sp, cp = sincos(pitch)
    wx, wy, wz = v, 0.0, 0.0
    if tables.bank_limits[SHAKE_X] < tables.bank_limits[SHAKE_Z + 1]:
        e, _, _ = envelope(tables, v, v1, v2)
        t = t_ns * 1e-9
        first = tables.bank_limits[SHAKE_X]
        for i in range(first, tables.bank.shape[1]):
            s, _ = sincos_turns(tables.bank[0, i] * t + tables.bank[1, i])
            scratch[i] = tables.bank[2, i] * s
        for i in range(first, tables.bank_limits[SHAKE_Y]):
            wx += e * scratch[i]
        for i in range(tables.bank_limits[SHAKE_Y], tables.bank_limits[SHAKE_Z]):
            wy += e * scratch[i]
        for i in range(tables.bank_limits[SHAKE_Z], tables.bank.shape[1]):
            wz += e * scratch[i]
    forward = cp * wx + sp * wz
    return cy * forward - sy * wy, sy * forward + cy * wy, cp * wz - sp * wx


@inner
def body_rates(
    yaw1: float, yaw2: float, pitch: float, p1: float, p2: float, roll: float, r1: float, r2: float
) -> tuple[float, float, float, float, float, float]:
    """ω and ω̇ of a Z-Y-X Euler frame in its own axes, from the angles' rates and accelerations."""
    sp, cp = sincos(pitch)
    sr, cr = sincos(roll)
    level = yaw1 * cp
    level1 = yaw2 * cp - yaw1 * p1 * sp
    return (
        r1 - yaw1 * sp,
        p1 * cr + level * sr,
        level * cr - p1 * sr,
        r2 - yaw2 * sp - yaw1 * p1 * cp,
        p2 * cr - p1 * r1 * sr + level1 * sr + level * r1 * cr,
        level1 * cr - level * r1 * sr - p2 * sr - p1 * r1 * cr,
    )


@inner
def euler_matrix(yaw: float, pitch: float, roll: float, out: NDArray[np.float64]) -> None:
    """C_n_b = Rz Ry Rx into out[C_NB …], by rows."""
    sy, cy = sincos(yaw)
    sp, cp = sincos(pitch)
    sr, cr = sincos(roll)
    out[C_NB] = cp * cy
    out[C_NB + 1] = sr * sp * cy - cr * sy
    out[C_NB + 2] = cr * sp * cy + sr * sy
    out[C_NB + 3] = cp * sy
    out[C_NB + 4] = sr * sp * sy + cr * cy
    out[C_NB + 5] = cr * sp * sy - sr * cy
    out[C_NB + 6] = -sp
    out[C_NB + 7] = sr * cp
    out[C_NB + 8] = cr * cp


@inner
def add_coning(
    tables: MotionTables, t_ns: int, e: float, e1: float, e2: float, out: NDArray[np.float64]
) -> None:
    """Turn C_n_b, ω_nb and ω̇_nb in `out` on by the coning motion R(ρ) of the body.

    ω_c = α̇ u + sin α u̇ − (1 − cos α) u × u̇ with u = (cos Ωt, sin Ωt, 0).
    """
    cone = tables.constants[CONE_ANGLE]
    frequency = tables.constants[CONE_FREQUENCY]
    k = TWO_PI * frequency
    alpha, a1, a2 = cone * e, cone * e1, cone * e2
    st, ct = sincos_turns(frequency * (t_ns * 1e-9))
    sa, ca = sincos(alpha)
    versine = 2.0 * sincos(0.5 * alpha)[0] * sincos(0.5 * alpha)[0]
    r00, r01, r02 = ca + versine * ct * ct, versine * ct * st, sa * st
    r11, r12 = ca + versine * st * st, -sa * ct
    for i in range(3):
        a, b, c = out[C_NB + 3 * i], out[C_NB + 3 * i + 1], out[C_NB + 3 * i + 2]
        out[C_NB + 3 * i] = a * r00 + b * r01 - c * r02
        out[C_NB + 3 * i + 1] = a * r01 + b * r11 - c * r12
        out[C_NB + 3 * i + 2] = a * r02 + b * r12 + c * ca
    x, y, z = out[OMEGA_IB], out[OMEGA_IB + 1], out[OMEGA_IB + 2]
    bx = r00 * x + r01 * y - r02 * z
    by = r01 * x + r11 * y - r12 * z
    bz = r02 * x + r12 * y + ca * z
    cx = a1 * ct - sa * k * st
    cy = a1 * st + sa * k * ct
    cz = -versine * k
    x, y, z = out[OMEGA_DOT], out[OMEGA_DOT + 1], out[OMEGA_DOT + 2]
    growth = a1 * k * (1.0 + ca)
    turning = sa * k * k
    out[OMEGA_DOT] = r00 * x + r01 * y - r02 * z - (cy * bz - cz * by) + a2 * ct - growth * st - turning * ct
    out[OMEGA_DOT + 1] = (
        r01 * x + r11 * y - r12 * z - (cz * bx - cx * bz) + a2 * st + growth * ct - turning * st
    )
    out[OMEGA_DOT + 2] = r02 * x + r12 * y + ca * z - (cx * by - cy * bx) - sa * k * a1
    out[OMEGA_IB] = bx + cx
    out[OMEGA_IB + 1] = by + cy
    out[OMEGA_IB + 2] = bz + cz


@inner
def motion_row(
    tables: MotionTables,
    row: NDArray[np.int64],
    t_ns: int,
    waves: NDArray[np.float64],
    shake: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Fill `out` (ROW) at `t_ns`; latitude, longitude and height must stand in it already."""
    find_pieces(tables, t_ns, row)
    v, v1, v2 = channel(tables, row, SPEED, t_ns)
    yaw, yaw1, yaw2 = channel(tables, row, YAW, t_ns)
    pitch, pitch1, pitch2 = channel(tables, row, PITCH, t_ns)
    roll, roll1, roll2 = channel(tables, row, ROLL, t_ns)
    e, e1, e2 = envelope(tables, v, v1, v2)
    shaking(tables, t_ns, waves, shake)

    wx, wy, wz = v + e * shake[SHAKE_X, 0], e * shake[SHAKE_Y, 0], e * shake[SHAKE_Z, 0]
    ax = v1 + e1 * shake[SHAKE_X, 0] + e * shake[SHAKE_X, 1]
    ay = e1 * shake[SHAKE_Y, 0] + e * shake[SHAKE_Y, 1]
    az = e1 * shake[SHAKE_Z, 0] + e * shake[SHAKE_Z, 1]
    sy, cy = sincos(yaw)
    sp, cp = sincos(pitch)
    px, pz = -yaw1 * sp, yaw1 * cp
    ax += pitch1 * wz - pz * wy
    ay += pz * wx - px * wz
    az += px * wy - pitch1 * wx
    forward, side = cp * wx + sp * wz, wy
    vn, ve, vd = cy * forward - sy * side, sy * forward + cy * side, cp * wz - sp * wx
    forward, side = cp * ax + sp * az, ay
    an, ae, ad = cy * forward - sy * side, sy * forward + cy * side, cp * az - sp * ax
    out[VELOCITY], out[VELOCITY + 1], out[VELOCITY + 2] = vn, ve, vd

    pitch += e * shake[SWAY_PITCH, 0]
    roll += e * shake[SWAY_ROLL, 0]
    euler_matrix(yaw + e * shake[SWAY_YAW, 0], pitch, roll, out)
    x, y, z, x1, y1, z1 = body_rates(
        yaw1 + e1 * shake[SWAY_YAW, 0] + e * shake[SWAY_YAW, 1],
        yaw2 + e2 * shake[SWAY_YAW, 0] + 2.0 * e1 * shake[SWAY_YAW, 1] + e * shake[SWAY_YAW, 2],
        pitch,
        pitch1 + e1 * shake[SWAY_PITCH, 0] + e * shake[SWAY_PITCH, 1],
        pitch2 + e2 * shake[SWAY_PITCH, 0] + 2.0 * e1 * shake[SWAY_PITCH, 1] + e * shake[SWAY_PITCH, 2],
        roll,
        roll1 + e1 * shake[SWAY_ROLL, 0] + e * shake[SWAY_ROLL, 1],
        roll2 + e2 * shake[SWAY_ROLL, 0] + 2.0 * e1 * shake[SWAY_ROLL, 1] + e * shake[SWAY_ROLL, 2],
    )
    out[OMEGA_IB], out[OMEGA_IB + 1], out[OMEGA_IB + 2] = x, y, z
    out[OMEGA_DOT], out[OMEGA_DOT + 1], out[OMEGA_DOT + 2] = x1, y1, z1
    if tables.constants[CONE_ANGLE] != 0.0:
        add_coning(tables, t_ns, e, e1, e2, out)
    add_earth(an, ae, ad, out)


@inner
def add_earth(an: float, ae: float, ad: float, out: NDArray[np.float64]) -> None:
    """Complete a row: ω_nb to ω_ib, ω̇_nb to ω̇_ib, and the specific force of the acceleration v̇_n given."""
    vn, ve, vd = out[VELOCITY], out[VELOCITY + 1], out[VELOCITY + 2]
    sl, cl = sincos(out[LATITUDE])
    m, n = radii(sl)
    m += out[HEIGHT]
    n += out[HEIGHT]
    tan = sl / cl
    ie_n, ie_d = EARTH_RATE * cl, -EARTH_RATE * sl
    en_n, en_e, en_d = ve / n, -vn / m, -ve * tan / n
    tn, te, td = 2.0 * ie_n + en_n, en_e, 2.0 * ie_d + en_d
    fn = an + te * vd - td * ve
    fe = ae + td * vn - tn * vd
    fd = ad + tn * ve - te * vn - gravity(sl, out[HEIGHT])
    in_n, in_d = ie_n + en_n, ie_d + en_d
    x, y, z = out[OMEGA_IB], out[OMEGA_IB + 1], out[OMEGA_IB + 2]
    rate = vn / m
    dn = ae / n - EARTH_RATE * sl * rate
    de = -an / m
    dd = -(ae * tan + ve * rate / (cl * cl)) / n - EARTH_RATE * cl * rate
    ix = out[C_NB] * in_n + out[C_NB + 3] * en_e + out[C_NB + 6] * in_d
    iy = out[C_NB + 1] * in_n + out[C_NB + 4] * en_e + out[C_NB + 7] * in_d
    iz = out[C_NB + 2] * in_n + out[C_NB + 5] * en_e + out[C_NB + 8] * in_d
    out[OMEGA_DOT] += out[C_NB] * dn + out[C_NB + 3] * de + out[C_NB + 6] * dd - (y * iz - z * iy)
    out[OMEGA_DOT + 1] += out[C_NB + 1] * dn + out[C_NB + 4] * de + out[C_NB + 7] * dd - (z * ix - x * iz)
    out[OMEGA_DOT + 2] += out[C_NB + 2] * dn + out[C_NB + 5] * de + out[C_NB + 8] * dd - (x * iy - y * ix)
    out[OMEGA_IB], out[OMEGA_IB + 1], out[OMEGA_IB + 2] = x + ix, y + iy, z + iz
    for i in range(3):
        out[FORCE + i] = out[C_NB + i] * fn + out[C_NB + 3 + i] * fe + out[C_NB + 6 + i] * fd
