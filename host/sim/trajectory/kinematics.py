"""Exact kinematics of the vehicle at any instant: what a perfect inertial sensor at its origin feels.

The path gives speed v, yaw ψ, pitch θ, roll φ as piecewise analytic functions. The vehicle drives along the
path's own axis x and vibrates about it by d (in path axes, millimetres); its body may sway:

    r = r_path + C_n_p d,   w = (v, 0, 0),   Ω = ω_np in path axes
    v_n = C_n_p (w + ḋ + Ω × d)
    v̇_n = C_n_p (ẇ + Ω × w + d̈ + 2 Ω × ḋ + Ω̇ × d + Ω × (Ω × d))
    C_n_b = Rz(ψ + ψ_s) Ry(θ + θ_s) Rx(φ + φ_s) R(ρ),   ρ = α (cos Ωt, sin Ωt, 0) the coning vector
    ω_ib = ω_nb + C_b_n (ω_ie + ω_en)
    f_b  = C_b_n (v̇_n + (2 ω_ie + ω_en) × v_n − g_n)

that is the strapdown mechanization of source 002 (eqs. 2-24 … 2-28, 3-23 … 3-32) solved for what the sensors
measure. Angular acceleration ω̇_ib is exact but for the change of the Earth's radii with time.
"""

from __future__ import annotations

from host.sim.compiled import Floats, inner
from host.sim.earth import EARTH_RATE, radii_and_gravity
from host.sim.sine import TWO_PI, sincos, sincos_turns
from host.sim.trajectory.lanes import (
    AD,
    AE,
    AN,
    BODY_PITCH,
    BODY_ROLL,
    BODY_YAW,
    COS,
    E1,
    E2,
    LANES,
    PATH_PITCH,
    PATH_YAW,
    PITCH1,
    PITCH2,
    PLACE,
    RM,
    RN,
    ROLL1,
    ROLL2,
    SIN,
    V1,
    YAW1,
    YAW2,
    E,
    G,
    V,
)
from host.sim.trajectory.shaking import SHIFT_X, SHIFT_Y, SHIFT_Z, SWAY_PITCH, SWAY_ROLL, SWAY_YAW
from host.sim.trajectory.tables import CONE_ANGLE, CONE_FREQUENCY

LATITUDE, LONGITUDE, HEIGHT = 0, 1, 2
VELOCITY = 3
C_NB = 6
OMEGA_IB = 15
FORCE = 18
OMEGA_DOT = 21
ROW = 24
"""Columns of a row of truth: lat, lon, h, v_n(3), C_n_b(9, by rows), ω_ib_b(3), f_b(3), ω̇_ib_b(3)."""


@inner
def add_body(
    angles: Floats,
    yaw1: float,
    yaw2: float,
    p1: float,
    p2: float,
    r1: float,
    r2: float,
    j: int,
    out: Floats,
) -> None:
    """C_n_b = Rz Ry Rx, ω_nb and ω̇_nb in body axes, from the angles' sines and their two derivatives."""
    sy, sp, sr = angles[SIN, BODY_YAW, j], angles[SIN, BODY_PITCH, j], angles[SIN, BODY_ROLL, j]
    cy, cp, cr = angles[COS, BODY_YAW, j], angles[COS, BODY_PITCH, j], angles[COS, BODY_ROLL, j]
    out[C_NB, j] = cp * cy
    out[C_NB + 1, j] = sr * sp * cy - cr * sy
    out[C_NB + 2, j] = cr * sp * cy + sr * sy
    out[C_NB + 3, j] = cp * sy
    out[C_NB + 4, j] = sr * sp * sy + cr * cy
    out[C_NB + 5, j] = cr * sp * sy - sr * cy
    out[C_NB + 6, j] = -sp
    out[C_NB + 7, j] = sr * cp
    out[C_NB + 8, j] = cr * cp
    level = yaw1 * cp
    level1 = yaw2 * cp - yaw1 * p1 * sp
    out[OMEGA_IB, j] = r1 - yaw1 * sp
    out[OMEGA_IB + 1, j] = p1 * cr + level * sr
    out[OMEGA_IB + 2, j] = level * cr - p1 * sr
    out[OMEGA_DOT, j] = r2 - yaw2 * sp - yaw1 * p1 * cp
    out[OMEGA_DOT + 1, j] = p2 * cr - p1 * r1 * sr + level1 * sr + level * r1 * cr
    out[OMEGA_DOT + 2, j] = level1 * cr - level * r1 * sr - p2 * sr - p1 * r1 * cr


@inner
def add_coning(constants: Floats, t: float, e: float, e1: float, e2: float, j: int, out: Floats) -> None:
    """Turn C_n_b, ω_nb and ω̇_nb in `out` on by the coning motion R(ρ) of the body.

    ω_c = α̇ u + sin α u̇ − (1 − cos α) u × u̇ with u = (cos Ωt, sin Ωt, 0).
    """
    cone = constants[CONE_ANGLE]
    frequency = constants[CONE_FREQUENCY]
    k = TWO_PI * frequency
    alpha, a1, a2 = cone * e, cone * e1, cone * e2
    st, ct = sincos_turns(frequency * t)
    sa, ca = sincos(alpha)
    versine = 2.0 * sincos(0.5 * alpha)[0] * sincos(0.5 * alpha)[0]
    r00, r01, r02 = ca + versine * ct * ct, versine * ct * st, sa * st
    r11, r12 = ca + versine * st * st, -sa * ct
    for i in range(3):
        a, b, c = out[C_NB + 3 * i, j], out[C_NB + 3 * i + 1, j], out[C_NB + 3 * i + 2, j]
        out[C_NB + 3 * i, j] = a * r00 + b * r01 - c * r02
        out[C_NB + 3 * i + 1, j] = a * r01 + b * r11 - c * r12
        out[C_NB + 3 * i + 2, j] = a * r02 + b * r12 + c * ca
    x, y, z = out[OMEGA_IB, j], out[OMEGA_IB + 1, j], out[OMEGA_IB + 2, j]
    bx = r00 * x + r01 * y - r02 * z
    by = r01 * x + r11 * y - r12 * z
    bz = r02 * x + r12 * y + ca * z
    cx = a1 * ct - sa * k * st
    cy = a1 * st + sa * k * ct
    cz = -versine * k
    x, y, z = out[OMEGA_DOT, j], out[OMEGA_DOT + 1, j], out[OMEGA_DOT + 2, j]
    growth = a1 * k * (1.0 + ca)
    turning = sa * k * k
    out[OMEGA_DOT, j] = (
        r00 * x + r01 * y - r02 * z - (cy * bz - cz * by) + a2 * ct - growth * st - turning * ct
    )
    out[OMEGA_DOT + 1, j] = (
        r01 * x + r11 * y - r12 * z - (cz * bx - cx * bz) + a2 * st + growth * ct - turning * st
    )
    out[OMEGA_DOT + 2, j] = r02 * x + r12 * y + ca * z - (cx * by - cy * bx) - sa * k * a1
    out[OMEGA_IB, j] = bx + cx
    out[OMEGA_IB + 1, j] = by + cy
    out[OMEGA_IB + 2, j] = bz + cz


@inner
def motion_rows(
    constants: Floats, times: Floats, path: Floats, angles: Floats, shake: Floats, out: Floats
) -> None:
    """Fill `out` (ROW, LANES) at `times` (s) from the lanes of `path`, `angles` and `shake` (see `lanes`).

    The path's latitude, longitude and height must stand in it already.
    """
    for j in range(LANES):
        yaw1, yaw2, pitch1, pitch2 = path[YAW1, j], path[YAW2, j], path[PITCH1, j], path[PITCH2, j]
        m, n, g = radii_and_gravity(angles[SIN, PLACE, j], out[HEIGHT, j])
        an, ae, ad = add_path(path[V, j], path[V1, j], yaw1, yaw2, pitch1, pitch2, angles, shake, j, out)
        path[AN, j], path[AE, j], path[AD, j] = an, ae, ad
        path[RM, j], path[RN, j], path[G, j] = m, n, g
        shift_position(1.0 / m, 1.0 / (n * angles[COS, PLACE, j]), angles, shake, j, out)
        add_body(
            angles,
            yaw1 + shake[SWAY_YAW, 1, j],
            yaw2 + shake[SWAY_YAW, 2, j],
            pitch1 + shake[SWAY_PITCH, 1, j],
            pitch2 + shake[SWAY_PITCH, 2, j],
            path[ROLL1, j] + shake[SWAY_ROLL, 1, j],
            path[ROLL2, j] + shake[SWAY_ROLL, 2, j],
            j,
            out,
        )
    if constants[CONE_ANGLE] != 0.0:
        for j in range(LANES):
            add_coning(constants, times[j], path[E, j], path[E1, j], path[E2, j], j, out)
    for j in range(LANES):
        add_earth(path, angles[SIN, PLACE, j], angles[COS, PLACE, j], j, out)


@inner
def add_path(
    v: float,
    v1: float,
    yaw1: float,
    yaw2: float,
    pitch1: float,
    pitch2: float,
    angles: Floats,
    shake: Floats,
    j: int,
    out: Floats,
) -> tuple[float, float, float]:
    """Write v_n and return v̇_n."""
    sy, sp = angles[SIN, PATH_YAW, j], angles[SIN, PATH_PITCH, j]
    cy, cp = angles[COS, PATH_YAW, j], angles[COS, PATH_PITCH, j]
    x, y, z = -yaw1 * sp, pitch1, yaw1 * cp
    x1, y1, z1 = -yaw2 * sp - yaw1 * pitch1 * cp, pitch2, yaw2 * cp - yaw1 * pitch1 * sp
    dx, dy, dz = shake[SHIFT_X, 0, j], shake[SHIFT_Y, 0, j], shake[SHIFT_Z, 0, j]
    ux, uy, uz = shake[SHIFT_X, 1, j], shake[SHIFT_Y, 1, j], shake[SHIFT_Z, 1, j]
    cx, cross_y, cz = y * dz - z * dy, z * dx - x * dz, x * dy - y * dx
    ax = v1 + shake[SHIFT_X, 2, j] + 2.0 * (y * uz - z * uy) + y1 * dz - z1 * dy + y * cz - z * cross_y
    ay = z * v + shake[SHIFT_Y, 2, j] + 2.0 * (z * ux - x * uz) + z1 * dx - x1 * dz + z * cx - x * cz
    az = -y * v + shake[SHIFT_Z, 2, j] + 2.0 * (x * uy - y * ux) + x1 * dy - y1 * dx + x * cross_y - y * cx
    wx, wy, wz = v + ux + cx, uy + cross_y, uz + cz
    forward = cp * wx + sp * wz
    out[VELOCITY, j], out[VELOCITY + 1, j] = cy * forward - sy * wy, sy * forward + cy * wy
    out[VELOCITY + 2, j] = cp * wz - sp * wx
    forward = cp * ax + sp * az
    return cy * forward - sy * ay, sy * forward + cy * ay, cp * az - sp * ax


@inner
def shift_position(
    lat_per_m: float,
    lon_per_m: float,
    angles: Floats,
    shake: Floats,
    j: int,
    out: Floats,
) -> None:
    """Move the position by the vibration."""
    sy, sp = angles[SIN, PATH_YAW, j], angles[SIN, PATH_PITCH, j]
    cy, cp = angles[COS, PATH_YAW, j], angles[COS, PATH_PITCH, j]
    dx, dy, dz = shake[SHIFT_X, 0, j], shake[SHIFT_Y, 0, j], shake[SHIFT_Z, 0, j]
    forward = cp * dx + sp * dz
    out[LATITUDE, j] += lat_per_m * (cy * forward - sy * dy)
    out[LONGITUDE, j] += lon_per_m * (sy * forward + cy * dy)
    out[HEIGHT, j] -= cp * dz - sp * dx


@inner
def add_earth(path: Floats, sl: float, cl: float, j: int, out: Floats) -> None:
    """Complete a lane: ω_nb to ω_ib, ω̇_nb to ω̇_ib, and the specific force of the acceleration v̇_n in `path`.

    `sl`, `cl`: sine and cosine of the latitude.
    """
    an, ae, ad = path[AN, j], path[AE, j], path[AD, j]
    m, n, g = path[RM, j], path[RN, j], path[G, j]
    vn, ve, vd = out[VELOCITY, j], out[VELOCITY + 1, j], out[VELOCITY + 2, j]
    by_m, by_n = 1.0 / m, 1.0 / n
    tan = sl / cl
    ie_n, ie_d = EARTH_RATE * cl, -EARTH_RATE * sl
    en_n, en_e, en_d = ve * by_n, -vn * by_m, -ve * tan * by_n
    tn, te, td = 2.0 * ie_n + en_n, en_e, 2.0 * ie_d + en_d
    fn = an + te * vd - td * ve
    fe = ae + td * vn - tn * vd
    fd = ad + tn * ve - te * vn - g
    in_n, in_d = ie_n + en_n, ie_d + en_d
    x, y, z = out[OMEGA_IB, j], out[OMEGA_IB + 1, j], out[OMEGA_IB + 2, j]
    rate = vn * by_m
    dn = ae * by_n - EARTH_RATE * sl * rate
    de = -an * by_m
    dd = -(ae * tan + ve * rate * (1.0 + tan * tan)) * by_n - EARTH_RATE * cl * rate
    ix = out[C_NB, j] * in_n + out[C_NB + 3, j] * en_e + out[C_NB + 6, j] * in_d
    iy = out[C_NB + 1, j] * in_n + out[C_NB + 4, j] * en_e + out[C_NB + 7, j] * in_d
    iz = out[C_NB + 2, j] * in_n + out[C_NB + 5, j] * en_e + out[C_NB + 8, j] * in_d
    out[OMEGA_DOT, j] += out[C_NB, j] * dn + out[C_NB + 3, j] * de + out[C_NB + 6, j] * dd - (y * iz - z * iy)
    out[OMEGA_DOT + 1, j] += (
        out[C_NB + 1, j] * dn + out[C_NB + 4, j] * de + out[C_NB + 7, j] * dd - (z * ix - x * iz)
    )
    out[OMEGA_DOT + 2, j] += (
        out[C_NB + 2, j] * dn + out[C_NB + 5, j] * de + out[C_NB + 8, j] * dd - (x * iy - y * ix)
    )
    out[OMEGA_IB, j], out[OMEGA_IB + 1, j], out[OMEGA_IB + 2, j] = x + ix, y + iy, z + iz
    for i in range(3):
        out[FORCE + i, j] = out[C_NB + i, j] * fn + out[C_NB + 3 + i, j] * fe + out[C_NB + 6 + i, j] * fd
