"""Strapdown mechanization in north-east-down, double precision, and its inverse, step by step.

Forward, from the increments Δθ, Δv of one interval (and Δθ', Δv' of the one before):

    φ    = Δθ + 1/12 Δθ' × Δθ                                                   coning
    Δv_s = Δv + A Δθ × Δv + B Δθ × (Δθ × Δv) + 1/12 (Δθ' × Δv + Δv' × Δθ)        rotation and sculling
           A = (1 − cos θ)/θ²,  B = (1 − sin θ/θ)/θ²,  θ = |Δθ|
    v⁺   = v + (I − ½ [ζ×]) C_n_b Δv_s + (g_n − (2 ω_ie + ω_en) × v̄) Δt,   ζ = (ω_ie + ω_en) Δt
    p⁺   = p + Δt (v̄ − b/12) over the radii,   v̄ = (v + v⁺)/2, radii, ω and g halfway
           b = (v⁺ − v) − (v − v⁻) makes up for what the trapezoid lacks where the acceleration is smooth;
           where it steps, the smaller of this b and the one before is taken, 0 if their signs differ
    q⁺   = q(−ζ) ⊗ q ⊗ q(φ)

source 002, chapter 2, with the terms of rotation and sculling for two neighbouring intervals (P. G. Savage,
*Strapdown Analytics*). v̄ makes it implicit; three passes settle it to rounding. The inverse finds the
increments that lead forward to a wanted velocity and attitude, by forward steps until nothing is left: both
agree to rounding by construction.
"""

from __future__ import annotations

import math

import numpy as np

from host.sim.compiled import Floats, entry, inner
from host.sim.earth import EARTH_RATE, radii_and_gravity
from host.sim.sine import sincos

LATITUDE, LONGITUDE, HEIGHT, VELOCITY, QUATERNION = 0, 1, 2, 3, 6
TURNED, PUSHED, GAINED, BENT, STATE = 10, 13, 16, 19, 22
"""A state: position, v_n, q_nb (scalar first), and of the interval before Δθ, Δv, the change of v_n, and how
much that was more than in the interval before it."""
PASSES = 3
ROUNDS = 12
SETTLED = 1e-15
PULL_PER_S = 0.1
"""How fast the closed loop takes back what the forward position has come off the wanted one."""


@inner
def rotation_quaternion(x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """The quaternion of a rotation vector."""
    square = x * x + y * y + z * z
    if square < 0.01:
        s = 0.5 * (1.0 - square / 24.0 * (1.0 - square / 80.0 * (1.0 - square / 168.0)))
        c = 1.0 - square / 8.0 * (1.0 - square / 48.0 * (1.0 - square / 120.0 * (1.0 - square / 224.0)))
        return c, s * x, s * y, s * z
    angle = math.sqrt(square)
    sin, c = sincos(0.5 * angle)
    s = sin / angle
    return c, s * x, s * y, s * z


@inner
def turned(q: Floats, k: int, w: float, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """The quaternion at q[k …] times another one."""
    a, b, c, d = q[k], q[k + 1], q[k + 2], q[k + 3]
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


@inner
def felt_in_start_frame(s: Floats, i: Floats, out: Floats) -> None:
    """Δv_s of increments `i` (Δθ, Δv) into out[0 … 2], φ into out[3 … 5]; `s` holds those before."""
    tx, ty, tz, vx, vy, vz = i[0], i[1], i[2], i[3], i[4], i[5]
    px, py, pz = s[TURNED], s[TURNED + 1], s[TURNED + 2]
    ux, uy, uz = s[PUSHED], s[PUSHED + 1], s[PUSHED + 2]
    square = tx * tx + ty * ty + tz * tz
    a = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0))
    b = 1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))
    cx, cy, cz = ty * vz - tz * vy, tz * vx - tx * vz, tx * vy - ty * vx
    dx, dy, dz = ty * cz - tz * cy, tz * cx - tx * cz, tx * cy - ty * cx
    ex = py * vz - pz * vy + uy * tz - uz * ty
    ey = pz * vx - px * vz + uz * tx - ux * tz
    ez = px * vy - py * vx + ux * ty - uy * tx
    out[0] = vx + a * cx + b * dx + ex / 12.0
    out[1] = vy + a * cy + b * dy + ey / 12.0
    out[2] = vz + a * cz + b * dz + ez / 12.0
    out[3] = tx + (py * tz - pz * ty) / 12.0
    out[4] = ty + (pz * tx - px * tz) / 12.0
    out[5] = tz + (px * ty - py * tx) / 12.0


@inner
def to_n(s: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """C_n_b of a state times a vector."""
    a, b, c, d = s[QUATERNION], s[QUATERNION + 1], s[QUATERNION + 2], s[QUATERNION + 3]
    return (
        (a * a + b * b - c * c - d * d) * x + 2.0 * (b * c - a * d) * y + 2.0 * (b * d + a * c) * z,
        2.0 * (b * c + a * d) * x + (a * a - b * b + c * c - d * d) * y + 2.0 * (c * d - a * b) * z,
        2.0 * (b * d - a * c) * x + 2.0 * (c * d + a * b) * y + (a * a - b * b - c * c + d * d) * z,
    )


@inner
def smaller(one: float, other: float) -> float:
    """Of two numbers of one sign the smaller one, else 0."""
    if one * other <= 0.0:
        return 0.0
    return one if abs(one) < abs(other) else other


@inner
def step(s: Floats, i: Floats, dt: float, scratch: Floats, out: Floats) -> None:
    """The state after an interval of `dt` with increments `i` (Δθ, Δv) from state `s` into `out`."""
    felt_in_start_frame(s, i, scratch)
    fn, fe, fd = to_n(s, scratch[0], scratch[1], scratch[2])
    vn, ve, vd = s[VELOCITY], s[VELOCITY + 1], s[VELOCITY + 2]
    wn, we, wd = vn, ve, vd
    zn, ze, zd = 0.0, 0.0, 0.0
    m, n, cl = 1.0, 1.0, 1.0
    for _ in range(PASSES):
        mn, me, md = 0.5 * (vn + wn), 0.5 * (ve + we), 0.5 * (vd + wd)
        height = s[HEIGHT] - 0.5 * dt * md
        latitude = s[LATITUDE] + 0.5 * dt * mn / m if m > 1.0 else s[LATITUDE]
        sl, cl = sincos(latitude)
        m, n, g = radii_and_gravity(sl, height)
        ien, ied = EARTH_RATE * cl, -EARTH_RATE * sl
        enn, ene, end = me / n, -mn / m, -me * sl / (n * cl)
        zn, ze, zd = (ien + enn) * dt, ene * dt, (ied + end) * dt
        cn, ce, cd = 2.0 * ien + enn, ene, 2.0 * ied + end
        wn = vn + fn - 0.5 * (ze * fd - zd * fe) - (ce * md - cd * me) * dt
        we = ve + fe - 0.5 * (zd * fn - zn * fd) - (cd * mn - cn * md) * dt
        wd = vd + fd - 0.5 * (zn * fe - ze * fn) - (cn * me - ce * mn) * dt + g * dt
    out[VELOCITY], out[VELOCITY + 1], out[VELOCITY + 2] = wn, we, wd
    gn, ge, gd = wn - vn, we - ve, wd - vd
    bn, be, bd = gn - s[GAINED], ge - s[GAINED + 1], gd - s[GAINED + 2]
    out[LATITUDE] = s[LATITUDE] + dt * (vn + 0.5 * gn - smaller(bn, s[BENT]) / 12.0) / m
    out[LONGITUDE] = s[LONGITUDE] + dt * (ve + 0.5 * ge - smaller(be, s[BENT + 1]) / 12.0) / (n * cl)
    out[HEIGHT] = s[HEIGHT] - dt * (vd + 0.5 * gd - smaller(bd, s[BENT + 2]) / 12.0)
    out[GAINED], out[GAINED + 1], out[GAINED + 2] = gn, ge, gd
    out[BENT], out[BENT + 1], out[BENT + 2] = bn, be, bd
    qw, qx, qy, qz = rotation_quaternion(scratch[3], scratch[4], scratch[5])
    scratch[0], scratch[1], scratch[2], scratch[3] = turned(s, QUATERNION, qw, qx, qy, qz)
    ew, ex, ey, ez = scratch[0], scratch[1], scratch[2], scratch[3]
    scratch[0], scratch[1], scratch[2], scratch[3] = rotation_quaternion(-zn, -ze, -zd)
    ew, ex, ey, ez = turned(scratch, 0, ew, ex, ey, ez)
    scale = 1.0 / math.sqrt(ew * ew + ex * ex + ey * ey + ez * ez)
    out[QUATERNION], out[QUATERNION + 1] = scale * ew, scale * ex
    out[QUATERNION + 2], out[QUATERNION + 3] = scale * ey, scale * ez
    for k in range(6):
        out[TURNED + k] = i[k]


@entry
def integrate(state: Floats, increments: Floats, lengths: Floats, out: Floats) -> None:
    """States (n, STATE) after each row of increments (n, 6: Δθ, Δv) of intervals of `lengths` (n) s."""
    now, after, scratch = state.copy(), state.copy(), np.empty(6)
    for k in range(increments.shape[0]):
        step(now, increments[k], lengths[k], scratch, after)
        for j in range(STATE):
            now[j] = after[j]
            out[k, j] = after[j]


@entry
def invert(state: Floats, wanted: Floats, lengths: Floats, increments: Floats, out: Floats) -> None:
    """Increments (n, 6) that lead along `wanted` (n, 10: position, velocity, q_nb), and the states (n, STATE)
    to which they lead, each found from the forward state before (closed loop, source 002, figure 3.7)."""
    now, after, scratch, guess = state.copy(), state.copy(), np.empty(6), np.empty(6)
    for k in range(6):
        guess[k] = state[TURNED + k]
    for k in range(wanted.shape[0]):
        dt = lengths[k]
        sl, cl = sincos(now[LATITUDE])
        m, n, _ = radii_and_gravity(sl, now[HEIGHT])
        pull = 0.0 if k == 0 else PULL_PER_S
        vn = wanted[k, VELOCITY]
        ve = wanted[k, VELOCITY + 1]
        vd = wanted[k, VELOCITY + 2]
        if k > 0:
            vn += pull * (wanted[k - 1, LATITUDE] - now[LATITUDE]) * m
            ve += pull * (wanted[k - 1, LONGITUDE] - now[LONGITUDE]) * n * cl
            vd -= pull * (wanted[k - 1, HEIGHT] - now[HEIGHT])
        for _ in range(ROUNDS):
            step(now, guess, dt, scratch, after)
            left = correct(now, after, wanted[k], vn, ve, vd, guess)
            if left < SETTLED:
                break
        step(now, guess, dt, scratch, after)
        for j in range(6):
            increments[k, j] = guess[j]
        for j in range(STATE):
            now[j] = after[j]
            out[k, j] = after[j]


@inner
def correct(s: Floats, after: Floats, wanted: Floats, vn: float, ve: float, vd: float, i: Floats) -> float:
    """Move the increments `i` by what `after` lacks of the wanted velocity and attitude; how much it was."""
    a, b, c, d = s[QUATERNION], -s[QUATERNION + 1], -s[QUATERNION + 2], -s[QUATERNION + 3]
    x, y, z = vn - after[VELOCITY], ve - after[VELOCITY + 1], vd - after[VELOCITY + 2]
    i[3] += (a * a + b * b - c * c - d * d) * x + 2.0 * (b * c - a * d) * y + 2.0 * (b * d + a * c) * z
    i[4] += 2.0 * (b * c + a * d) * x + (a * a - b * b + c * c - d * d) * y + 2.0 * (c * d - a * b) * z
    i[5] += 2.0 * (b * d - a * c) * x + 2.0 * (c * d + a * b) * y + (a * a - b * b - c * c + d * d) * z
    a, b, c, d = after[QUATERNION], -after[QUATERNION + 1], -after[QUATERNION + 2], -after[QUATERNION + 3]
    w, p, q, r = wanted[QUATERNION], wanted[QUATERNION + 1], wanted[QUATERNION + 2], wanted[QUATERNION + 3]
    sign = 2.0 if a * w - b * p - c * q - d * r >= 0.0 else -2.0
    tx = sign * (a * p + b * w + c * r - d * q)
    ty = sign * (a * q - b * r + c * w + d * p)
    tz = sign * (a * r + b * q - c * p + d * w)
    i[0] += tx
    i[1] += ty
    i[2] += tz
    return abs(x) + abs(y) + abs(z) + abs(tx) + abs(ty) + abs(tz)
