"""U D Uᵀ in float32 against a dense covariance in float64, and its soundness over very many cycles."""

import numpy as np
import pytest

from firmware.nav import layout as at
from firmware.nav.attitude_reset import turn_attitude_error
from firmware.nav.covariance import absorb_projected, add_variance, project, scale_state
from firmware.nav.measurement import weigh_group
from firmware.numerics.dialect import kernel

N = at.STATES


@kernel("void(float32[::1], int32)")
def absorb_rows(f, count):
    """Absorb the first rows one after the other."""
    for row in range(count):
        project(f, row)
        absorb_projected(f, row)


@kernel("void(float32[::1], int32, float32)")
def add(f, state, variance):
    """Process noise of one state."""
    add_variance(f, state, variance)


@kernel("void(float32[::1], int32, float32)")
def scale(f, state, factor):
    """Decay of one state."""
    scale_state(f, state, factor)


@kernel("void(float32[::1], float32, float32, float32)")
def turn(f, x, y, z):
    """Attitude reset."""
    turn_attitude_error(f, x, y, z)


@kernel("float32(float32[::1], int32)")
def weigh(f, count):
    """Normalised innovation of the first rows."""
    return weigh_group(f, 0, count)


def dense(f):
    """P in float64."""
    U = np.eye(N) + np.triu(f[at.U : at.U + N * N].astype(float).reshape(N, N).T, 1)
    return U @ np.diag(f[at.D : at.D + N].astype(float)) @ U.T


def random_factor(rng, spread=3.0):
    """A state array with a random covariance, its D over several decades."""
    f = np.zeros(at.F_SIZE, np.float32)
    U = np.triu(rng.normal(size=(N, N)) * 0.3, 1)
    f[at.U : at.U + N * N] = U.T.ravel()
    f[at.D : at.D + N] = 10.0 ** rng.uniform(-spread, spread, N)
    return f


def fill_rows(f, H, residuals, variances):
    """Measurement rows, residuals and variances into their places; nothing estimated yet."""
    f[at.ROWS : at.ROWS + H.size] = H.ravel()
    f[at.RESIDUAL : at.RESIDUAL + len(H)] = residuals
    f[at.VARIANCE : at.VARIANCE + len(H)] = variances
    f[at.CORRECTION : at.CORRECTION + N] = 0.0


def joseph(P, x, H, z, R):
    """One update of a dense filter, Joseph form."""
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S)
    A = np.eye(N) - K @ H
    return A @ P @ A.T + K @ R @ K.T, x + K @ (z - H @ x)


def same(P, expected, tolerance):
    """Relative to the standard deviations."""
    d = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(P / np.outer(d, d), expected / np.outer(d, d), atol=tolerance)


@pytest.mark.parametrize("seed", range(5))
def test_update_equals_dense_joseph(seed):
    """Six scalars, one after the other, against one update of a dense filter by all of them."""
    rng = np.random.default_rng(seed)
    f = random_factor(rng)
    H = rng.normal(size=(6, N)) * (rng.random((6, N)) < 0.3)
    residuals, variances = rng.normal(size=6), 10.0 ** rng.uniform(-2, 2, 6)
    fill_rows(f, H, residuals, variances)
    expected, x = joseph(dense(f), np.zeros(N), H, residuals, np.diag(variances))
    absorb_rows(f, 6)
    same(dense(f), expected, 1e-4)
    deviations = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(f[at.CORRECTION : at.CORRECTION + N] / deviations, x / deviations, atol=2e-3)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_weight_of_a_group(count):
    """ν' S⁻¹ ν by numpy."""
    rng = np.random.default_rng(count)
    f = random_factor(rng, spread=1.0)
    H, z, R = rng.normal(size=(count, N)), rng.normal(size=count), rng.uniform(0.1, 2.0, count)
    fill_rows(f, H, z, R)
    S = H @ dense(f) @ H.T + np.diag(R)
    assert weigh(f, count) == pytest.approx(z @ np.linalg.solve(S, z), rel=1e-3)
    sigmas = f[at.INNOVATION_SIGMA : at.INNOVATION_SIGMA + count]
    np.testing.assert_allclose(sigmas, np.sqrt(np.diag(S)), rtol=1e-5)


@pytest.mark.parametrize("state", [0, 1, 8, 9, 20, N - 1])
def test_noise_and_decay_of_one_state(state):
    """P + q e eᵀ and S P S."""
    rng = np.random.default_rng(state)
    f = random_factor(rng)
    expected = dense(f)
    expected[state, state] += 0.7
    add(f, state, 0.7)
    same(dense(f), expected, 1e-5)
    if state >= at.X_GYRO_BIAS:
        S = np.eye(N)
        S[state, state] = 0.9
        scale(f, state, 0.9)
        same(dense(f), S @ expected @ S, 1e-5)


def test_attitude_reset_turns_three_rows():
    """G P Gᵀ with G = I − [φ̂×]/2 in the attitude block."""
    rng = np.random.default_rng(11)
    f = random_factor(rng, spread=1.0)
    v = np.array([0.05, -0.08, 0.2])
    G = np.eye(N)
    G[6:9, 6:9] -= np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    expected = G @ dense(f) @ G.T
    turn(f, *v)
    same(dense(f), expected, 1e-5)
    assert np.all(f[at.D : at.D + N] >= 0.0)


def test_known_state_stays_known():
    """A state without variance (latency with a time pulse) gets no correction and no variance."""
    rng = np.random.default_rng(3)
    f = random_factor(rng)
    f[at.D + at.X_LATENCY] = 0.0
    f[at.U + N * at.X_LATENCY : at.U + N * at.X_LATENCY + at.X_LATENCY] = 0.0
    for j in range(at.X_LATENCY + 1, N):
        f[at.U + N * j + at.X_LATENCY] = 0.0
    fill_rows(f, rng.normal(size=(6, N)), np.ones(6), np.ones(6))
    absorb_rows(f, 6)
    assert f[at.CORRECTION + at.X_LATENCY] == 0.0
    assert dense(f)[at.X_LATENCY, at.X_LATENCY] == 0.0


@kernel("void(float32[::1], int32)")
def many_cycles(f, count):
    """Noise to one state after the other, one precise measurement after the other: hard on a covariance."""
    state = np.int32(0)
    for n in range(count):
        add_variance(f, state, f[at.CORRECTION + state] * f[at.CORRECTION + state] + SMALL)
        for k in range(np.int32(N)):
            f[at.ROWS + k] = ZERO
        f[at.ROWS + state] = ONE
        f[at.ROWS + (state + np.int32(7)) % np.int32(N)] = HALF
        f[at.RESIDUAL] = HALF
        f[at.VARIANCE] = SMALL if n & 1 else ONE
        project(f, 0)
        absorb_projected(f, 0)
        for k in range(np.int32(N)):
            f[at.CORRECTION + k] = ZERO
        state = np.int32((state + np.int32(5)) % np.int32(N))


ZERO, HALF, ONE, SMALL = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(1e-6)


def test_stays_positive_over_a_hundred_thousand_cycles():
    """Variances from 1e-6 to 1e3, measurements a million times better than the prior."""
    f = random_factor(np.random.default_rng(5))
    for _ in range(10):
        many_cycles(f, 12_000)
        P = dense(f)
        eigenvalues = np.linalg.eigvalsh(P)
        assert np.all(np.isfinite(P))
        assert np.all(f[at.D : at.D + N] >= 0.0)
        assert eigenvalues[0] > -1e-12 * eigenvalues[-1]
