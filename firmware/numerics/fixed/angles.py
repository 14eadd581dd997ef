"""Binary angles: a full turn is 2³² units of 1.46e-9 rad, and angles wrap as 32-bit numbers do.

    function        argument                      result                    largest error
    sine_cosine     any integer, modulo 2³²       Q30                       1 unit (9e-10)
    arc_tangent2    |y|, |x| < 2⁶¹                −2³¹ … 2³¹ − 1            1.6 units (2.3e-9 rad)
    arc_sine        Q30, beyond ±1 as ±1          −2³⁰ … 2³⁰                1.6 units, and near ±1 the
                                                                            part of the argument's own unit

Sine and cosine: the nearest quarter turn q off, the rest u = −½ … ½ quarter turns,

    sin(π/2·u) = u · (s₀ − u²(s₁ − …)),  cos(π/2·u) = 1 − u²(c₁ − u²(c₂ − …)),  s_k, c_k = (π/2)ⁿ/n!

up to u¹¹ and u¹⁰ (left out: 7e-12, 1.2e-10). Arc tangent: the point is brought into the first octant and
turned back by π/16 or 3π/16, so that t = y/x is below 0.2; atan t up to t¹¹ (left out: 6e-11). Signs of the
point (0, 0) and of an angle of exactly half a turn: 0 and −2³¹.
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import in_q, leading_bit, product, rounded_shift
from firmware.numerics.fixed.roots import reciprocal_mantissa, square_root

QUARTER_TURN = 1 << 30
HALF_TURN = 1 << 31
FULL_TURN = 1 << 32
ONE_Q30 = 1 << 30
ONE_Q60 = 1 << 60

_R = math.pi / 2.0
S0, S1, S2, S3, S4, S5 = (in_q(_R**n / math.factorial(n), 30) for n in (1, 3, 5, 7, 9, 11))
C1, C2, C3, C4, C5 = (in_q(_R**n / math.factorial(n), 30) for n in (2, 4, 6, 8, 10))

# atan t in turns, of t in Q31
_T = 1.0 / (2.0 * math.pi)
A0, A1, A2, A3, A4, A5 = (in_q(_T / n, 32) for n in (1, 3, 5, 7, 9, 11))
TANGENT_EIGHTH = in_q(math.tan(math.pi / 8.0), 30)
COS_1, SIN_1 = in_q(math.cos(math.pi / 16.0), 30), in_q(math.sin(math.pi / 16.0), 30)
COS_3, SIN_3 = in_q(math.cos(3.0 * math.pi / 16.0), 30), in_q(math.sin(3.0 * math.pi / 16.0), 30)
TURN_1 = FULL_TURN >> 5
TURN_3 = 3 * TURN_1

NANORADIANS_Q30 = in_q(1.0e9 * math.pi / 2.0, 0)
"""1e-9 rad a unit, in Q30."""


def angle_of_radians(angle: float) -> int:
    """The binary angle of `angle` in rad, −2³¹ … 2³¹ − 1; for constants and configuration."""
    turns = angle / (2.0 * math.pi)
    return (round(turns * FULL_TURN) + HALF_TURN) % FULL_TURN - HALF_TURN


@kernel("int64(int64)")
def wrap(angle):
    """The same angle in −2³¹ … 2³¹ − 1."""
    return ((angle + HALF_TURN) & (FULL_TURN - 1)) - HALF_TURN


@kernel("int64(int64)")
def nanoradians(angle):
    """1e-9 rad of an angle of up to a turn, not wrapped."""
    return product(angle, NANORADIANS_Q30, 30)


@kernel("UniTuple(int64, 2)(int64)")
def sine_cosine(angle):
    """Sine and cosine in Q30."""
    angle = wrap(angle)
    quarter = (angle + (QUARTER_TURN >> 1)) >> 30
    u = (angle - (quarter << 30)) << 1  # Q31, |u| ≤ ½
    square = rounded_shift(u * u, 30)  # Q32
    p = S4 - product(S5, square, 32)
    p = S3 - product(p, square, 32)
    p = S2 - product(p, square, 32)
    p = S1 - product(p, square, 32)
    p = S0 - product(p, square, 32)
    sine = product(p, u, 31)
    p = C4 - product(C5, square, 32)
    p = C3 - product(p, square, 32)
    p = C2 - product(p, square, 32)
    p = C1 - product(p, square, 32)
    cosine = ONE_Q30 - product(p, square, 32)
    if quarter & 1 != 0:
        sine, cosine = cosine, -sine
    if quarter & 2 != 0:
        sine, cosine = -sine, -cosine
    return sine, cosine


@kernel("int64(int64, int64)")
def arc_tangent2(y, x):
    """Angle of the point (x, y) from the x axis."""
    ax = abs(x)
    ay = abs(y)
    large = max(ax, ay)
    small = min(ax, ay)
    if large == 0:
        return np.int64(0)
    e = leading_bit(large)
    if e <= 30:
        large <<= 30 - e
        small <<= 30 - e
    else:
        large >>= e - 30
        small >>= e - 30
    angle = _first_octant(small, large)
    if ay > ax:
        angle = QUARTER_TURN - angle
    if x < 0:
        angle = HALF_TURN - angle
    if y < 0:
        angle = -angle
    return wrap(angle)


@kernel
def _first_octant(small, large):
    """Angle whose tangent is small/large, 0 ≤ small ≤ large, 2³⁰ ≤ large < 2³¹."""
    if small < product(large, TANGENT_EIGHTH, 30):
        cosine = np.int64(COS_1)
        sine = np.int64(SIN_1)
        turned = np.int64(TURN_1)
    else:
        cosine = np.int64(COS_3)
        sine = np.int64(SIN_3)
        turned = np.int64(TURN_3)
    along = rounded_shift(large * cosine + small * sine, 31)
    across = rounded_shift(small * cosine - large * sine, 30)
    e = leading_bit(along)
    t = product(across, reciprocal_mantissa(along << (30 - e)), e + 1)  # Q31: across/along, |t| < 0.2
    square = rounded_shift(t * t, 30)  # Q32
    p = A4 - product(A5, square, 32)
    p = A3 - product(p, square, 32)
    p = A2 - product(p, square, 32)
    p = A1 - product(p, square, 32)
    p = A0 - product(p, square, 32)
    return turned + product(p, t, 31)


@kernel("int64(int64)")
def arc_sine(x):
    """Angle, −2³⁰ … 2³⁰, whose sine is x in Q30."""
    x = min(max(x, np.int64(-ONE_Q30)), np.int64(ONE_Q30))
    return arc_tangent2(x, square_root(ONE_Q60 - x * x))
