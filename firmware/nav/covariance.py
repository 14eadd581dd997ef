"""The covariance as P = U D Uᵀ: never asymmetric, never negative, in float32.

U is unit upper triangular, D diagonal. Both lie in `f` (layout.U, column by column, and layout.D), so that
every inner loop runs over one contiguous column and sums nothing but whole columns.

    measurement update   Bierman, Factorization Methods for Discrete Sequential Estimation (1977), ch. V
    dynamics, process noise of the dynamic states: modified weighted Gram-Schmidt of Thornton, ibid. ch. VI
    process noise of one state (rank one)          Agee and Turner (1972), ibid. ch. III

The parameters stand behind the nine dynamic states. Their part of U does not change when the dynamics act,
and only the first nine rows need new triangular form: P_xx = U_xx D_x U_xxᵀ + U_xp D_p U_xpᵀ, of which the
second term stays as the rows were mapped (Bierman, ch. VII, "mapping with bias parameters").
"""

import numpy as np

from firmware.nav import layout as at
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
LARGEST = np.float32(1.0e12)
N = np.int32(at.STATES)
NX = np.int32(at.DYNAMIC_STATES)
COLUMNS = np.int32(at.WORK_COLUMNS)
ONE_STEP = np.int32(1)


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
            for j in range(k + ONE_STEP, N):
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
    for j in range(N):
        column = at.U + j * at.STATES
        fj = f[p + j]
        d = f[at.D + j]
        g = d * fj
        before = alpha
        alpha = before + fj * g
        f[at.D + j] = d * (before / alpha)
        back = -fj / before
        for k in range(np.int32(j)):
            u = f[column + k]
            f[column + k] = u + back * f[at.GAIN + k]
            f[at.GAIN + k] += g * u
        f[at.GAIN + j] = g
    step = residual / alpha
    for j in range(N):
        f[at.CORRECTION + j] += f[at.GAIN + j] * step


@kernel
def retriangularise(f):
    """Bring the first nine rows of U, mapped and no longer triangular, to triangular form again.

    Columns 0 … 8 of layout.WORK hold the mapped U_xx, and layout.WORK_WEIGHT their D; the nine columns after
    them are noise: unit vectors, weighted by the variances that the caller has set.
    """
    for j in range(NX):
        column = at.WORK + (at.DYNAMIC_STATES + j) * 9
        for k in range(NX):
            f[column + k] = ZERO
        f[column + j] = ONE
    for back in range(NX):
        k = at.DYNAMIC_STATES - 1 - back
        _weigh_columns(f, k)
        d = f[at.WORK_SUM + k]
        f[at.D + k] = d
        scale = ONE / d if d > ZERO else ZERO
        for m in range(NX):
            f[at.WORK_SUM + m] = scale * f[at.WORK_SUM + m] if m < k else ZERO
        for m in range(np.int32(k)):
            f[at.U + k * at.STATES + m] = f[at.WORK_SUM + m]
        _subtract_row(f, k)


@kernel
def _weigh_columns(f, k):
    """Σ over the columns of weight · W[k] · W[0 … 8] to layout.WORK_SUM, nine sums in registers."""
    s0 = ZERO
    s1 = ZERO
    s2 = ZERO
    s3 = ZERO
    s4 = ZERO
    s5 = ZERO
    s6 = ZERO
    s7 = ZERO
    s8 = ZERO
    for j in range(COLUMNS):
        if j < NX or j >= k + at.DYNAMIC_STATES:  # the unit vectors before have nothing in row k yet
            c = at.WORK + j * 9
            w = f[at.WORK_WEIGHT + j] * f[c + k]
            s0 += w * f[c]
            s1 += w * f[c + 1]
            s2 += w * f[c + 2]
            s3 += w * f[c + 3]
            s4 += w * f[c + 4]
            s5 += w * f[c + 5]
            s6 += w * f[c + 6]
            s7 += w * f[c + 7]
            s8 += w * f[c + 8]
    f[at.WORK_SUM] = s0
    f[at.WORK_SUM + 1] = s1
    f[at.WORK_SUM + 2] = s2
    f[at.WORK_SUM + 3] = s3
    f[at.WORK_SUM + 4] = s4
    f[at.WORK_SUM + 5] = s5
    f[at.WORK_SUM + 6] = s6
    f[at.WORK_SUM + 7] = s7
    f[at.WORK_SUM + 8] = s8


@kernel
def _subtract_row(f, k):
    """Take the part along row k, layout.WORK_SUM, off every row above it."""
    u0 = f[at.WORK_SUM]
    u1 = f[at.WORK_SUM + 1]
    u2 = f[at.WORK_SUM + 2]
    u3 = f[at.WORK_SUM + 3]
    u4 = f[at.WORK_SUM + 4]
    u5 = f[at.WORK_SUM + 5]
    u6 = f[at.WORK_SUM + 6]
    u7 = f[at.WORK_SUM + 7]
    u8 = f[at.WORK_SUM + 8]
    for j in range(COLUMNS):
        if j < NX or j >= k + at.DYNAMIC_STATES:
            c = at.WORK + j * 9
            w = f[c + k]
            f[c] -= u0 * w
            f[c + 1] -= u1 * w
            f[c + 2] -= u2 * w
            f[c + 3] -= u3 * w
            f[c + 4] -= u4 * w
            f[c + 5] -= u5 * w
            f[c + 6] -= u6 * w
            f[c + 7] -= u7 * w
            f[c + 8] -= u8 * w


@kernel
def add_variance(f, state, variance):
    """P += variance · e eᵀ for one state: process noise of a parameter, or a state made uncertain again."""
    for j in range(np.int32(state)):
        f[at.GAIN + j] = ZERO
    f[at.GAIN + state] = ONE
    c = variance
    for back in range(np.int32(state + 1)):
        j = state - back
        a = f[at.GAIN + j]
        d = f[at.D + j]
        after = d + c * a * a
        if after > ZERO:
            column = at.U + j * at.STATES
            share = c * a / after
            for k in range(np.int32(j)):
                rest = f[at.GAIN + k] - a * f[column + k]
                f[at.GAIN + k] = rest
                f[column + k] += share * rest
            f[at.D + j] = after
            c = c * (d / after)


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
    """Whether D is finite and not negative; NaN anywhere in U reaches D with the next update."""
    for j in range(N):
        d = f[at.D + j]
        if not (d >= ZERO and d < LARGEST):
            return False
    return True
