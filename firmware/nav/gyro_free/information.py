"""Estimates passed from filter to filter: information added, and shared, without inverting a covariance.

An estimate x̂ with P = V Δ V' (V unit upper triangular) says the same as independent scalar measurements

    V⁻¹ x̂ = V⁻¹ x + v,   var v_k = Δ_k

so a filter that absorbs these rows by its ordinary update ends with P_f = (Σ P_i⁻¹)⁻¹, x_f = P_f Σ P_i⁻¹ x_i.

To keep the share β of the information on the common states c and leave what is known of the private ones
given c, p(x) is divided by N(c; P_c)^(1 − β): the rows V⁻¹ of the marginal P_c are absorbed with variances
−Δ_k / (1 − β). P_c becomes P_c / β; every intermediate divisor is −Δ_k β / (1 − β) or larger in size, never
near zero. Without private states this scales D by 1/β.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav.covariance import absorb_projected, element, project
from firmware.nav.feedback import clear_correction, feed_back
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.states import ALL, COMMON, COMPASS_ERROR, X_COMPASS_ERROR
from firmware.nav.measurement import clear_rows
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
FOUR = np.float32(4.0)
THREE = np.int32(3)
LEAST = np.float32(1.0e-25)
"""A variance below is none."""
N = gl.FACTOR_STATES
INDEX_MASK = 31


@kernel
def factor_estimate(g, f, states):
    """V, Δ of the leading `states` of P, private ones put in their noise; and V⁻¹."""
    for j in range(np.int32(states)):
        g[gl.FACTOR_D + j] = f[at.D + j]
        for k in range(np.int32(j)):
            g[gl.FACTOR + j * N + k] = f[at.U + j * at.STATES + k]
    for j in range(np.int32(states), np.int32(ALL)):
        if f[at.D + j] > ZERO:
            for k in range(np.int32(states)):
                g[gl.VECTOR + k] = f[at.U + j * at.STATES + k]
            _add_rank_one(g, states, f[at.D + j])
    _invert(g, states)


@kernel
def _add_rank_one(g, states, variance):
    """V Δ V' += variance · a a' with a in layout.VECTOR (Agee and Turner)."""
    c = variance
    for back in range(np.int32(states)):
        j = (states - 1 - back) & INDEX_MASK
        a = g[gl.VECTOR + j]
        d = g[gl.FACTOR_D + j]
        after = d + c * a * a
        if after > ZERO:
            per_after = ONE / after
            share = c * a * per_after
            for k in range(np.int32(j)):
                rest = g[gl.VECTOR + k] - a * g[gl.FACTOR + j * N + k]
                g[gl.VECTOR + k] = rest
                g[gl.FACTOR + j * N + k] += share * rest
            g[gl.FACTOR_D + j] = after
            c = c * (d * per_after)


@kernel
def _invert(g, states):
    """V⁻¹ row by row, the last row first."""
    for back in range(np.int32(states)):
        k = (states - 1 - back) & INDEX_MASK
        row = gl.WHITE + k * N
        for j in range(np.int32(states)):
            g[row + j] = ONE if j == k else ZERO
        for m in range(np.int32(k + 1), np.int32(states)):
            v = g[gl.FACTOR + m * N + k]
            for j in range(np.int32(m), np.int32(states)):
                g[row + j] -= v * g[gl.WHITE + m * N + j]


@kernel
def _put_row(g, f, k, states):
    """Row k of V⁻¹ as measurement row 0, and what it says of layout.DIFFERENCE."""
    total = ZERO
    for j in range(np.int32(states)):
        w = g[gl.WHITE + k * N + j]
        f[at.ROWS + j] = w
        total += w * g[gl.DIFFERENCE + j]
    f[at.RESIDUAL] = total


@kernel
def absorb_estimate(g, f, states):
    """The factored estimate, layout.DIFFERENCE off that of `f`, goes into `f`; x̂ gathers in CORRECTION."""
    clear_rows(f)
    for k in range(np.int32(states)):
        _put_row(g, f, k, states)
        f[at.VARIANCE] = max(g[gl.FACTOR_D + k], LEAST)
        project(f, 0)
        absorb_projected(f, 0)


@kernel
def largest_difference(g, f, states):
    """Of the factored estimate from `f`: largest square of a row's difference over its variance."""
    clear_rows(f)
    worst = ZERO
    for k in range(np.int32(states)):
        _put_row(g, f, k, states)
        project(f, 0)
        variance = g[gl.FACTOR_D + k] + LEAST
        for j in range(np.int32(at.STATES)):
            p = f[at.PROJECTED + j]
            variance += p * p * f[at.D + j]
        worst = max(worst, f[at.RESIDUAL] * f[at.RESIDUAL] / variance)
    return worst


@kernel
def keep_share(g, f, share):
    """`f` keeps the share β of what it knows of the common states."""
    if not share < ONE:
        return
    private = ZERO
    for j in range(np.int32(COMMON), np.int32(ALL)):
        private += f[at.D + j]
    if private == ZERO:
        for j in range(np.int32(COMMON)):
            f[at.D + j] /= share
        return
    factor_estimate(g, f, COMMON)
    for j in range(np.int32(COMMON)):
        g[gl.DIFFERENCE + j] = ZERO
    clear_rows(f)
    clear_correction(f)
    for k in range(np.int32(COMMON)):
        if g[gl.FACTOR_D + k] > LEAST:
            _put_row(g, f, k, COMMON)
            f[at.VARIANCE] = -g[gl.FACTOR_D + k] / (ONE - share)
            project(f, 0)
            absorb_projected(f, 0)


@kernel
def copy_covariance(source, target):
    """U and D, whole."""
    for k in range(np.int32(at.STATES * at.STATES)):
        target[at.U + k] = source[at.U + k]
    for j in range(np.int32(at.STATES)):
        target[at.D + j] = source[at.D + j]


@kernel
def drop_private(g, f):
    """Only the common states stay, their covariance as it is."""
    factor_estimate(g, f, COMMON)
    for j in range(np.int32(COMMON)):
        f[at.D + j] = g[gl.FACTOR_D + j]
        for k in range(np.int32(j)):
            f[at.U + j * at.STATES + k] = g[gl.FACTOR + j * N + k]
    for j in range(np.int32(COMMON), np.int32(ALL)):
        f[at.D + j] = ZERO
        for k in range(np.int32(j)):
            f[at.U + j * at.STATES + k] = ZERO


@kernel
def bound_compass_error(g, f, i):
    """The error of the compass stays within twice what it is when nothing is known of it: what it is at any
    time. A share of the information leaves it wider where the other share of heading is soon forgotten."""
    clear_rows(f)
    clear_correction(f)
    bounded = False
    for k in range(THREE):
        state = np.int32(X_COMPASS_ERROR + k)
        limit = FOUR * g[gl.COMPASS_ERROR_VARIANCE + (1 if k == 2 else 0)]
        variance = element(f, state, state)
        if variance > limit:
            bounded = True
            f[at.ROWS + state] = ONE
            f[at.RESIDUAL] = -f[COMPASS_ERROR + k]
            f[at.VARIANCE] = limit * variance / (variance - limit)
            project(f, 0)
            absorb_projected(f, 0)
            f[at.ROWS + state] = ZERO
    if bounded:
        feed_back(f, i)
