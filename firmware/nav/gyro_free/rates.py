"""Angular rate by one of four methods, from one sample of nine accelerometers to the next.

    integration    ∫ω̇ dt by the parabola through three samples; its error grows with √t and with every bias
    square root    |ω_x| = √|(ω_x ω_y)(ω_x ω_z) / (ω_y ω_z)|, cyclic, with the sign of the integral
    differential   ω_x = (ω_x ω_y ω̇_z + ω_x ω_z ω̇_y) Δt / (ω_y ω_z − ω_y ω_z(t − Δt) + Δt² ω̇_y ω̇_z), cyclic
                   (the document's 3.4 to 3.6)
    fused          a filter over ω̇ and the products (fusion)

Where the divisor of the second or third is less than what noise makes of zero (layout.LEAST_PRODUCT,
LEAST_CHANGE), that axis is the integral, and counted. The document means its three methods to be used
together without saying how; here they can be chosen and compared.
"""

import math

import numpy as np

from firmware.nav.gyro_free import layout as at
from firmware.nav.gyro_free.fusion import fuse
from firmware.nav.gyro_free.geometry import resolve_rotation
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
FIVE = np.float32(5.0)
EIGHT = np.float32(8.0)
TWELFTH = np.float32(1.0 / 12.0)
HUGE = np.float32(1.0e6)
LONGEST_INTERVAL = np.float32(0.05)
"""s: over a longer one noise of two samples is not integrated, the rate stays."""
UNKNOWN_SQUARE = np.float32(0.04)
"""Unknown ω̇ of lost time, (rad/s²)²."""
THREE = np.int32(3)
NINE = np.int32(9)


@kernel("boolean(float32[::1], int64[::1], float32)")
def rate_step(g, n, dt):
    """layout.ACCELERATION, `dt` s after the sample before, to OMEGA and FORCE; False: no numbers, nothing
    done."""
    total = abs(dt)
    for k in range(NINE):
        total += abs(g[at.ACCELERATION + k])
    if not total < HUGE:
        n[at.REFUSED] += 1
        return False
    resolve_rotation(g)
    n[at.SAMPLES] += 1
    if n[at.HAVE_SAMPLE] == 0 or dt > LONGEST_INTERVAL:
        unknown = dt * dt * UNKNOWN_SQUARE if n[at.HAVE_SAMPLE] != 0 else ZERO
        n[at.HAVE_SAMPLE] = 1
        for k in range(THREE):
            g[at.FUSED_COVARIANCE + 4 * k] += unknown
            g[at.ANGULAR_ACCELERATION_BEFORE + k] = g[at.ANGULAR_ACCELERATION + k]
            g[at.PRODUCTS_BEFORE + k] = g[at.PRODUCTS + k]
    else:
        _advance(g, n, dt)
    _calibrate(g)
    return True


@kernel
def _advance(g, n, dt):
    for k in range(THREE):
        mean = FIVE * g[at.ANGULAR_ACCELERATION + k] + EIGHT * g[at.ANGULAR_ACCELERATION_BEFORE + k]
        mean -= g[at.ANGULAR_ACCELERATION_TWO_BEFORE + k]
        g[at.INCREMENT + k] = TWELFTH * dt * mean
        step = g[at.INCREMENT + k] + g[at.INTEGRAL_REST + k]
        before = g[at.INTEGRAL + k]
        g[at.INTEGRAL + k] = before + step
        g[at.INTEGRAL_REST + k] = step - (g[at.INTEGRAL + k] - before)
        g[at.METHOD_RATE + k] = g[at.INTEGRAL + k]
    if n[at.METHOD] == at.SQUARE_ROOT:
        _take_root(g, n, 0, 0, 2, 1)
        _take_root(g, n, 1, 0, 1, 2)
        _take_root(g, n, 2, 2, 1, 0)
    elif n[at.METHOD] == at.DIFFERENTIAL:
        _take_quotient(g, n, dt, 0, 1, 2, 0, 2, 1)
        _take_quotient(g, n, dt, 1, 0, 2, 0, 1, 2)
        _take_quotient(g, n, dt, 2, 0, 1, 2, 1, 0)
    elif n[at.METHOD] == at.FUSION:
        fuse(g, dt)
        for k in range(THREE):
            g[at.METHOD_RATE + k] = g[at.FUSED + k]


@kernel
def _take_root(g, n, axis, first, second, divisor):
    """The rate about `axis`: `first` and `second` are the products with it, `divisor` the third."""
    below = g[at.PRODUCTS + divisor]
    if abs(below) > g[at.LEAST_PRODUCT]:
        square = g[at.PRODUCTS + first] * g[at.PRODUCTS + second] / below
        root = np.float32(math.sqrt(abs(square)))
        g[at.METHOD_RATE + axis] = np.float32(math.copysign(root, g[at.INTEGRAL + axis]))
    else:
        n[at.FALLBACKS] += 1


@kernel
def _take_quotient(g, n, dt, axis, a, b, with_a, with_b, other):
    """The rate about `axis`: `with_a` is its product with ω_a, `with_b` with ω_b, `other` is ω_a ω_b."""
    da = g[at.ANGULAR_ACCELERATION + a]
    db = g[at.ANGULAR_ACCELERATION + b]
    below = g[at.PRODUCTS + other] - g[at.PRODUCTS_BEFORE + other] + dt * dt * da * db
    if abs(below) > g[at.LEAST_CHANGE]:
        above = (g[at.PRODUCTS + with_a] * db + g[at.PRODUCTS + with_b] * da) * dt
        g[at.METHOD_RATE + axis] = above / below
    else:
        n[at.FALLBACKS] += 1


@kernel
def _calibrate(g):
    """Scale, misalignment and bias of the equivalent rates, and of the three accelerometers at the origin."""
    r = at.METHOD_RATE
    a = at.ACCELERATION + 6
    for k in range(THREE):
        m = at.RATE_MATRIX + 3 * k
        rate = g[m] * g[r] + g[m + 1] * g[r + 1] + g[m + 2] * g[r + 2]
        g[at.OMEGA + k] = rate - g[at.RATE_BIAS + k]
        m = at.FORCE_MATRIX + 3 * k
        force = g[m] * g[a] + g[m + 1] * g[a + 1] + g[m + 2] * g[a + 2]
        g[at.FORCE + k] = force - g[at.FORCE_BIAS + k]
