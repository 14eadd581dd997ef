"""Sine, cosine, arc tangent, arc sine and square root in float32: the same bits on every machine.

The C library of each platform rounds differently, so these are polynomials of our own, evaluated in plain
float32 multiplications and additions.

Reduction (Cody and Waite, Software Manual for the Elementary Functions, 1980): x = k·π/2 + r, |r| ≤ π/4,
with π/2 split into four parts of which the first three have 11 bits, so that k times each of them is exact
for k < 2¹³. What does not fit into one float32 r is kept beside it as a correction.
Polynomials: weighted minimax fits in z = r², their coefficients rounded to float32 one after the other.

    function            range                 largest error (units in the last place of the exact result)
    sine, cosine        |x| ≤ 8192 rad        0.95
    arc_tangent2        all                   1.6
    arc_sine            |x| ≤ 1               2.0
    square_root         x ≥ 0                 0.5 (exactly rounded)

What lies outside: sine and cosine of more than 8192 rad are NaN (the reduction would lose digits and the
conversion to an integer would be undefined); |x| > 1 counts as 1 in arc_sine, because elements of a rotation
matrix exceed 1 by rounding; the square root of a negative number is NaN. NaN gives NaN everywhere.
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
NAN = np.float32(np.nan)

PI = np.float32(3.14159265358979)
HALF_PI = np.float32(1.57079632679490)
HALF_PI_TAIL = np.float32(-4.371139000186e-8)  # π/2 minus its float32
TWO_OVER_PI = np.float32(0.636619772367581)

LARGEST_ANGLE = np.float32(8192.0)
HALF_PI_1 = np.float32(1.5703125)
HALF_PI_2 = np.float32(4.837512969970703e-4)
HALF_PI_3 = np.float32(7.549533620476723e-8)
HALF_PI_4 = np.float32(2.5633440682570896e-12)

SIN_1 = np.float32(-0.16666655)
SIN_2 = np.float32(0.008332188)
SIN_3 = np.float32(-0.00019518097)
COS_1 = np.float32(0.041666646)
COS_2 = np.float32(-0.001388731)
COS_3 = np.float32(2.4432327e-05)

ATAN_1 = np.float32(-0.333333)
ATAN_2 = np.float32(0.1999853)
ATAN_3 = np.float32(-0.14264016)
ATAN_4 = np.float32(0.109508805)
ATAN_5 = np.float32(-0.083993055)
ATAN_6 = np.float32(0.057881337)
ATAN_7 = np.float32(-0.03109686)
ATAN_8 = np.float32(0.0108685605)
ATAN_9 = np.float32(-0.001782776)
SCALE_UP_BELOW = np.float32(1.0e-30)  # the quotient of smaller numbers loses bits where subnormals begin
SCALE_UP = np.float32(2.0**30)
LARGEST = np.float32(3.4028235e38)

ASIN_1 = np.float32(0.16666752)
ASIN_2 = np.float32(0.074953094)
ASIN_3 = np.float32(0.04546915)
ASIN_4 = np.float32(0.024184778)
ASIN_5 = np.float32(0.042158306)


@kernel("UniTuple(float32, 2)(float32)")
def sine_cosine(x):
    """Sine and cosine of the angle x in rad, |x| ≤ 8192; NaN beyond."""
    magnitude = abs(x)
    if not magnitude <= LARGEST_ANGLE:
        return NAN, NAN
    quarter = np.int32(magnitude * TWO_OVER_PI + HALF)
    k = np.float32(quarter)
    rest = (magnitude - k * HALF_PI_1) - k * HALF_PI_2
    tail = k * HALF_PI_3
    r = rest - tail
    correction = ((rest - r) - tail) - k * HALF_PI_4
    z = r * r
    s = r + (correction + r * (z * (SIN_1 + z * (SIN_2 + z * SIN_3))))
    half_z = HALF * z
    c = ONE - half_z
    c = c + (((ONE - c) - half_z) + (z * z * (COS_1 + z * (COS_2 + z * COS_3)) - r * correction))
    if quarter & 1:
        s, c = c, -s
    if quarter & 2:
        s, c = -s, -c
    return s * np.float32(math.copysign(ONE, x)), c


@kernel("float32(float32)")
def sine(x):
    """Sine of x in rad; where the cosine is needed too, `sine_cosine` gives both for the price of one."""
    return sine_cosine(x)[0]


@kernel("float32(float32)")
def cosine(x):
    """Cosine of x in rad."""
    return sine_cosine(x)[1]


@kernel("float32(float32, float32)")
def arc_tangent2(y, x):
    """Angle of the point (x, y) from the x axis, [−π, π] rad, with the signs of zero as in C's atan2."""
    if math.isnan(x) or math.isnan(y):
        return NAN
    ax = abs(x)
    ay = abs(y)
    if ax > LARGEST or ay > LARGEST:
        # Infinite: only which of the two is infinite matters.
        ax = ONE if ax > LARGEST else ZERO
        ay = ONE if ay > LARGEST else ZERO
    large = max(ax, ay)
    small = min(ax, ay)
    if large < SCALE_UP_BELOW:
        large = large * SCALE_UP
        small = small * SCALE_UP
    t = small / large if large > ZERO else ZERO
    z = t * t
    p = ATAN_5 + z * (ATAN_6 + z * (ATAN_7 + z * (ATAN_8 + z * ATAN_9)))
    p = ATAN_1 + z * (ATAN_2 + z * (ATAN_3 + z * (ATAN_4 + z * p)))
    angle = t + t * (z * p)
    if ay > ax:
        angle = (HALF_PI - angle) + HALF_PI_TAIL
    if np.float32(math.copysign(ONE, x)) < ZERO:
        angle = (PI - angle) + TWO * HALF_PI_TAIL
    return np.float32(math.copysign(angle, y))


@kernel("float32(float32)")
def arc_sine(x):
    """Angle whose sine is x, [−π/2, π/2] rad; |x| > 1 counts as 1."""
    if math.isnan(x):
        return NAN
    magnitude = min(abs(x), ONE)
    if magnitude <= HALF:
        angle = _arc_sine_series(magnitude, magnitude * magnitude)
    else:
        # sin²(a/2) = (1 − cos a)/2 with a = π/2 − angle
        z = HALF * (ONE - magnitude)
        angle = (HALF_PI - TWO * _arc_sine_series(np.float32(math.sqrt(z)), z)) + HALF_PI_TAIL
    return np.float32(math.copysign(angle, x))


@kernel
def _arc_sine_series(s, z):
    """Arc sine of s for 0 ≤ s ≤ 0.5, z = s²."""
    return s + s * (z * (ASIN_1 + z * (ASIN_2 + z * (ASIN_3 + z * (ASIN_4 + z * ASIN_5)))))


@kernel("float32(float32)")
def square_root(x):
    """Square root of x; NaN for a negative number (the interpreted `math.sqrt` would raise)."""
    if x < ZERO:
        return NAN
    return np.float32(math.sqrt(x))
