"""Prediction of the loosely coupled reference filter: strapdown in double precision, and its covariance.

Errors x = (δr, δv, φ, b_g, b_a): estimated minus true in north-east-down (m, m/s, rad), and what of the
biases is not yet estimated (true minus estimated, rad/s, m/s²). With Ĉ = (I − [φ×]) C:

    δṙ = δv − ω_en × δr
    δv̇ = f_n × φ − (2 ω_ie + ω_en) × δv + (0, 0, 2 g/R δr_D) + C b_a + w_a
    φ̇  = −ω_in × φ + δω_en(δv) − C b_g − w_g,      ḃ = −b/T + w_b,  S(w_b) = 2 σ²/T

source 002, section 2.4 (phi angle, first-order Gauss–Markov biases); Φ = I + F Δt over GROUP samples.
"""

from __future__ import annotations

import numpy as np

from host.sim.compiled import Floats, entry, inner
from host.sim.earth import EARTH_RATE, radii_and_gravity
from host.sim.mechanization import HEIGHT, LATITUDE, STATE, VELOCITY, step, to_n
from host.sim.sine import sincos

POSITION, SPEED, TILT, BIAS_G, BIAS_A, ERRORS = 0, 3, 6, 9, 12, 15
WALK_G, WALK_A, SIGMA_G, SIGMA_A, TIME_G, TIME_A, TUNING = 0, 3, 6, 9, 12, 15, 18
"""Tuning, per axis: random walks N (rad/√s, m/s/√s), σ and T of the biases."""
GROUP = 5
"""Samples between two steps of the covariance."""


@entry
def predict(
    state: Floats, bias: Floats, p: Floats, increments: Floats, lengths: Floats, tuning: Floats
) -> None:
    """Carry `state` (of `host.sim.mechanization`), `bias` (6: gyro, accelerometer) and the covariance `p`
    over increments (n, 6: Δθ, Δv) of intervals of `lengths` (n) s, in place."""
    corrected, after, scratch = np.empty(6), np.empty(STATE), np.empty(6)
    phi, half, q = np.empty((ERRORS, ERRORS)), np.empty((ERRORS, ERRORS)), np.empty(ERRORS)
    pushed = np.zeros(3)
    dt = 0.0
    for k in range(increments.shape[0]):
        for j in range(6):
            corrected[j] = increments[k, j] - bias[j] * lengths[k]
        step(state, corrected, lengths[k], scratch, after)
        for j in range(STATE):
            state[j] = after[j]
        for j in range(3):
            pushed[j] += corrected[3 + j]
        dt += lengths[k]
        if (k + 1) % GROUP == 0 or k + 1 == increments.shape[0]:
            fill_transition(state, pushed, dt, tuning, phi)
            fill_noise(dt, tuning, q)
            spread(phi, q, half, p)
            for j in range(6):
                bias[j] -= bias[j] * dt / tuning[TIME_G + j]
            for j in range(3):
                pushed[j] = 0.0
            dt = 0.0


@inner
def fill_noise(dt: float, tuning: Floats, q: Floats) -> None:
    """The diagonal of what `dt` adds to the covariance."""
    for i in range(3):
        q[POSITION + i] = 0.0
        q[SPEED + i] = tuning[WALK_A + i] * tuning[WALK_A + i] * dt
        q[TILT + i] = tuning[WALK_G + i] * tuning[WALK_G + i] * dt
    for i in range(6):
        q[BIAS_G + i] = 2.0 * tuning[SIGMA_G + i] * tuning[SIGMA_G + i] * dt / tuning[TIME_G + i]


@inner
def add_cross(phi: Floats, row: int, column: int, x: float, y: float, z: float) -> None:
    """Add the matrix of (x, y, z) × to a block."""
    phi[row, column + 1] -= z
    phi[row, column + 2] += y
    phi[row + 1, column] += z
    phi[row + 1, column + 2] -= x
    phi[row + 2, column] -= y
    phi[row + 2, column + 1] += x


@inner
def fill_transition(s: Floats, pushed: Floats, dt: float, tuning: Floats, phi: Floats) -> None:
    """Φ over `dt`, in which the body's velocity was `pushed` (3) by the specific force."""
    for i in range(ERRORS):
        for j in range(ERRORS):
            phi[i, j] = 1.0 if i == j else 0.0
    sl, cl = sincos(s[LATITUDE])
    m, n, g = radii_and_gravity(sl, s[HEIGHT])
    ve, vn = s[VELOCITY + 1], s[VELOCITY]
    ien, ied = EARTH_RATE * cl * dt, -EARTH_RATE * sl * dt
    enn, ene, end = ve / n * dt, -vn / m * dt, -ve * sl / (n * cl) * dt
    add_cross(phi, POSITION, POSITION, -enn, -ene, -end)
    add_cross(phi, SPEED, SPEED, -2.0 * ien - enn, -ene, -2.0 * ied - end)
    add_cross(phi, TILT, TILT, -ien - enn, -ene, -ied - end)
    fn, fe, fd = to_n(s, pushed[0], pushed[1], pushed[2])
    add_cross(phi, SPEED, TILT, fn, fe, fd)
    phi[SPEED + 2, POSITION + 2] += 2.0 * g / m * dt
    phi[TILT, SPEED + 1] += dt / n
    phi[TILT + 1, SPEED] -= dt / m
    phi[TILT + 2, SPEED + 1] -= dt * sl / (n * cl)
    for j in range(3):
        phi[POSITION + j, SPEED + j] += dt
        x, y, z = to_n(s, 1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0)
        phi[SPEED, BIAS_A + j] += x * dt
        phi[SPEED + 1, BIAS_A + j] += y * dt
        phi[SPEED + 2, BIAS_A + j] += z * dt
        phi[TILT, BIAS_G + j] -= x * dt
        phi[TILT + 1, BIAS_G + j] -= y * dt
        phi[TILT + 2, BIAS_G + j] -= z * dt
    for j in range(6):
        phi[BIAS_G + j, BIAS_G + j] -= dt / tuning[TIME_G + j]


@inner
def spread(phi: Floats, q: Floats, half: Floats, p: Floats) -> None:
    """P ← Φ P Φᵀ + diag(q)."""
    for i in range(ERRORS):
        for j in range(ERRORS):
            half[i, j] = 0.0
        for k in range(ERRORS):
            if phi[i, k] != 0.0:
                for j in range(ERRORS):
                    half[i, j] += phi[i, k] * p[k, j]
    for i in range(ERRORS):
        for j in range(i, ERRORS):
            total = 0.0
            for k in range(ERRORS):
                total += half[i, k] * phi[j, k]
            p[i, j] = total
            p[j, i] = total
        p[i, i] += q[i]
