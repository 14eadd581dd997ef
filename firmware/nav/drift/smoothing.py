"""Low-pass filters that keep their digits in float32 and follow a changing sample interval.

A Butterworth filter of second order, ω_c = √2/τ, as two trapezoidal integrators (state-variable form):

    h = (x − (√2 + g) s₁ − s₂) / (1 + √2 g + g²),    g = tan(dt / (√2 τ))
    v₁ = g h,   b = s₁ + v₁,   s₁ ← b + v₁;        v₂ = g b,   y = s₂ + v₂,   s₂ ← y + v₂

Its transfer function is that of the bilinear transform. In direct form the coefficients of τ = 3 s at 285 Hz
are 7·10⁻⁷, and rounding errors of the state are amplified by 1/g² = 1.5·10⁶; here y moves by
what was added to it, and an error in s₁ or s₂ is one of the output, not more.

Until its age reaches τ a smoother is the mean of what came (after Laidig & Seel 2023): weight =
dt/age. Setting the age back makes it learn quickly again, with the old value counting for that age.
"""

import numpy as np

from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
SIX = np.float32(6.0)
FIFTEEN = np.float32(15.0)
ROOT_2 = np.float32(1.4142135623730951)
HALF_ROOT_2 = np.float32(0.7071067811865476)
LARGEST_ARGUMENT = np.float32(1.0)


@kernel
def coefficients(dt, tau):
    """(g, 1/(1 + √2 g + g²)) of a sample interval and a time constant; samples too seldom for it pass."""
    x = min(HALF_ROOT_2 * dt / tau, LARGEST_ARGUMENT)
    square = x * x
    g = x * (FIFTEEN - square) / (FIFTEEN - SIX * square)
    return g, ONE / (ONE + g * (ROOT_2 + g))


@kernel
def grown(d, age, dt, tau):
    """Let a smoother's age grow by dt. Returns the weight of a sample in the mean, 0 when past that."""
    if d[age] >= tau:
        return ZERO
    d[age] = d[age] + dt
    return dt / d[age]


@kernel
def smooth(d, at, channels, gain, weight, x):
    """Feed the channel at index `at` of a smoother of `channels`; `gain`: where its coefficients lie."""
    low = d[at + channels]
    if weight > ZERO:
        low = low + weight * (x - low)
        d[at] = ZERO
        d[at + channels] = low
        return low
    g = d[gain]
    band = d[at]
    step = g * ((x - (ROOT_2 + g) * band - low) * d[gain + 1])
    band = band + step
    d[at] = band + step
    step = g * band
    low = low + step
    d[at + channels] = low + step
    return low
