"""What `trigonometry` computes, by the C library: stands in its place in the float64 variant of the kernels.

Not a kernel of the dialect: it runs on the PC only, for error budgets. Limits and special values are those of
`trigonometry`; the accuracy is that of float64 (about 1e-16).
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel

NAN = np.float64(np.nan)
LARGEST_ANGLE = np.float64(8192.0)
ZERO = np.float64(0.0)
ONE = np.float64(1.0)


@kernel("UniTuple(float64, 2)(float64)")
def sine_cosine(x):
    """Sine and cosine of the angle x in rad, |x| ≤ 8192; NaN beyond."""
    if not abs(x) <= LARGEST_ANGLE:
        return NAN, NAN
    return np.float64(math.sin(x)), np.float64(math.cos(x))


@kernel("float64(float64)")
def sine(x):
    """Sine of x in rad."""
    return sine_cosine(x)[0]


@kernel("float64(float64)")
def cosine(x):
    """Cosine of x in rad."""
    return sine_cosine(x)[1]


@kernel("float64(float64, float64)")
def arc_tangent2(y, x):
    """Angle of the point (x, y) from the x axis, [−π, π] rad."""
    return np.float64(math.atan2(y, x))


@kernel("float64(float64)")
def arc_sine(x):
    """Angle whose sine is x, [−π/2, π/2] rad; |x| > 1 counts as 1."""
    if math.isnan(x):
        return NAN
    return np.float64(math.asin(min(max(x, -ONE), ONE)))


@kernel("float64(float64)")
def square_root(x):
    """Square root of x; NaN for a negative number."""
    if x < ZERO:
        return NAN
    return np.float64(math.sqrt(x))
