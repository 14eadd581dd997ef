"""The covariance as P = U D Uᵀ: never asymmetric, never negative, in float32.

U is unit upper triangular, D diagonal. Both lie in `f` (layout.U, column by column, and layout.D), so that
inner loops run down one contiguous column.

    measurement update                 Bierman, Factorization Methods for Discrete Sequential Estimation
    (1977), ch. V
    process noise of one state         rank one, Agee and Turner (1972), ibid. ch. III

The order of the states makes the dynamics upper triangular as well: a state is driven by those behind it only
(position by velocity, velocity by attitude, both by the parameters). Φ U is then unit upper triangular again,
D stays, and no orthogonalisation is needed (prediction).
"""

import numpy as np

from firmware.nav import layout as at
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
LARGEST = np.float32(1.0e12)
INDEX_MASK = 63
"""Tells the compiler that an index is not negative; it then leaves out Python's wrap-around."""
N = np.int32(at.STATES)


@kernel
def project(f, row):
    """Uᵀ hᵀ of measurement row number `row` (layout.ROWS, mostly zeros) to layout.PROJECTED."""
    h = at.ROWS + row * at.STATES
    out = at.PROJECTED + row * at.STATES
    for j in range(N):
        f[out + j] = f[h + j]
    for k in range(N):
        hk = f[h + k]
        if hk != ZERO:
            for j in range(np.int32(k + 1), N):
                f[out + j] += hk * f[at.U + j * at.STATES + k]


@kernel
def projected_product(f, row_a, row_b):
    """h_a P h_bᵀ of two projected rows."""
    a = at.PROJECTED + row_a * at.STATES
    b = at.PROJECTED + row_b * at.STATES
    total = ZERO
    for j in range(N):
        total += f[a + j] * f[at.D + j] * f[b + j]
    return total


@kernel
def remaining_residual(f, row):
    """Residual of a row less what the scalars absorbed before it have found."""
    h = at.ROWS + row * at.STATES
    residual = f[at.RESIDUAL + row]
    for j in range(N):
        residual -= f[h + j] * f[at.CORRECTION + j]
    return residual


@kernel
def absorb_projected(f, row):
    """Update by the scalar of `row`, which has just been projected; x̂ in layout.CORRECTION moves with it."""
    residual = remaining_residual(f, row)
    p = at.PROJECTED + row * at.STATES
    alpha = f[at.VARIANCE + row]
    per_alpha = ONE / alpha
    for j in range(N):
        column = at.U + j * at.STATES
        fj = f[p + j]
        d = f[at.D + j]
        g = d * fj
        back = -fj * per_alpha
        before = alpha
        alpha = before + fj * g
        per_alpha = ONE / alpha
        f[at.D + j] = d * (before * per_alpha)
        for k in range(np.int32(j)):
            u = f[column + k]
            f[column + k] = u + back * f[at.GAIN + k]
            f[at.GAIN + k] += g * u
        f[at.GAIN + j] = g
    step = residual * per_alpha
    for j in range(N):
        f[at.CORRECTION + j] += f[at.GAIN + j] * step


@kernel
def add_variance(f, state, variance):
    """P += variance · e eᵀ for one state: process noise of a parameter, or a state made uncertain again."""
    for j in range(np.int32(state)):
        f[at.GAIN + j] = ZERO
    f[at.GAIN + state] = ONE
    add_along_gain(f, state, variance)


@kernel
def add_along_gain(f, last, variance):
    """P += variance · g gᵀ, g in layout.GAIN up to state `last`, zero behind it; g is spoilt."""
    c = variance
    for back in range(np.int32(last + 1)):
        j = (last - back) & INDEX_MASK
        a = f[at.GAIN + j]
        d = f[at.D + j]
        after = d + c * a * a
        if after > ZERO:
            column = at.U + j * at.STATES
            per_after = ONE / after
            share = c * a * per_after
            for k in range(np.int32(j)):
                rest = f[at.GAIN + k] - a * f[column + k]
                f[at.GAIN + k] = rest
                f[column + k] += share * rest
            f[at.D + j] = after
            c = c * (d * per_after)


@kernel
def scale_state(f, state, factor):
    """x → factor · x for one parameter: the decay of a Gauss-Markov process. `factor` > 0."""
    inverse = ONE / factor
    column = at.U + state * at.STATES
    for k in range(np.int32(state)):
        f[column + k] *= inverse
    for j in range(np.int32(state + 1), N):
        f[at.U + j * at.STATES + state] *= factor
    f[at.D + state] *= factor * factor


@kernel
def element(f, a, b):
    """P[a, b], with a ≤ b."""
    total = ZERO
    for j in range(np.int32(b), N):
        column = at.U + j * at.STATES
        ua = ONE if a == j else f[column + a]
        ub = ONE if b == j else f[column + b]
        total += ua * f[at.D + j] * ub
    return total


@kernel
def clear(f):
    """No uncertainty and no correlation."""
    for k in range(np.int32(at.STATES * at.STATES)):
        f[at.U + k] = ZERO
    for j in range(N):
        f[at.D + j] = ZERO


@kernel
def is_sound(f):
    """Whether D is finite and not negative, and U finite: what is not spreads with every update."""
    for j in range(N):
        d = f[at.D + j]
        if not (d >= ZERO and d < LARGEST):
            return False
    total = ZERO
    for k in range(np.int32(at.STATES * at.STATES)):
        total += abs(f[at.U + k])
    return total < LARGEST
