"""Angular rate from ω̇ and the products together: a filter of three states that divides by no rate.

    ω ← ω + ∫ω̇ dt                                                P ← P + Δt² q I
    z = ω_a ω_b + v   for (a, b) = (x, y), (y, z), (x, z)         H = ω_b at a, ω_a at b

The variance of v is (σ_a / l)², q a few times that (slow errors of ω̇). Since z is bilinear its mean is
ω_a ω_b + P_ab and its own spread P_aa P_bb + P_ab², exact for a Gaussian state; with both, a wide state is
not believed beyond what a product can tell. A rate that is not significant (below 4 σ) is no factor by which
to learn the other: the noise of the filter's own estimate would pass for information. S ≥ var v > 0 is the
only divisor. About one axis the products bound the other two rates; the third is then the integral. Joseph's
update keeps P positive in float32. The sign of ω as a whole comes from the beginning.
(Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), sections 5.2
and 10.3.)
"""

import numpy as np

from firmware.nav.gyro_free import layout as at
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE = np.int32(3)
SIGNIFICANT = np.float32(16.0)
"""4 σ, squared."""


@kernel
def fuse(g, dt):
    """One sample of ω̇ and products, `dt` s after the one before."""
    noise = g[at.RATE_NOISE_VARIANCE]
    for k in range(THREE):
        step = g[at.INCREMENT + k] + g[at.FUSED_REST + k]
        before = g[at.FUSED + k]
        g[at.FUSED + k] = before + step
        g[at.FUSED_REST + k] = step - (g[at.FUSED + k] - before)
        g[at.FUSED_COVARIANCE + 4 * k] += dt * dt * g[at.INCREMENT_VARIANCE]
    _absorb_product(g, 0, 1, g[at.PRODUCTS], noise)
    _absorb_product(g, 1, 2, g[at.PRODUCTS + 1], noise)
    _absorb_product(g, 0, 2, g[at.PRODUCTS + 2], noise)


@kernel
def _absorb_product(g, a, b, z, noise):
    p = at.FUSED_COVARIANCE
    wa = g[at.FUSED + a]
    wb = g[at.FUSED + b]
    aa = g[p + 4 * a]
    bb = g[p + 4 * b]
    ab = g[p + 3 * a + b]
    own = aa * bb + ab * ab + noise
    innovation = z - wa * wb - ab
    if wb * wb < SIGNIFICANT * bb:
        own += wb * wb * aa
        wb = ZERO
    if wa * wa < SIGNIFICANT * aa:
        own += wa * wa * bb
        wa = ZERO
    s = wb * wb * aa + TWO * wa * wb * ab + wa * wa * bb + own
    per_s = ONE / s
    for j in range(THREE):
        gain = (g[p + 3 * j + a] * wb + g[p + 3 * j + b] * wa) * per_s
        g[at.GAIN + j] = gain
        g[at.FUSED + j] += gain * innovation
    # P ← (I − K H) P (I − K H)' + K own K'
    for j in range(THREE):
        for k in range(THREE):
            seen = wb * g[p + 3 * a + k] + wa * g[p + 3 * b + k]
            g[at.WORK + 3 * j + k] = g[p + 3 * j + k] - g[at.GAIN + j] * seen
    for j in range(THREE):
        seen = wb * g[at.WORK + 3 * j + a] + wa * g[at.WORK + 3 * j + b]
        for k in range(np.int32(j), THREE):
            gain = g[at.GAIN + k]
            value = g[at.WORK + 3 * j + k] - seen * gain + g[at.GAIN + j] * own * gain
            g[p + 3 * j + k] = value
            g[p + 3 * k + j] = value
