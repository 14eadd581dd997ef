"""Small linear least squares on board, one equation after the other, never forming normal equations.

Information R x = z with R upper triangular (square-root information); each equation h x = y of unit variance
is turned into it by Givens rotations, so that the condition of the problem is not squared. After all:

    x = R⁻¹ z,   covariance R⁻¹ R⁻ᵀ · σ²,   σ² = sum of squared residuals / (equations − unknowns)

(Golub and Van Loan, Matrix Computations, section 5.2; Bierman 1977, ch. IV.)

Array `q`: R row by row (n × n, stride 8), z, the row being absorbed, sum of squares, number of equations,
then x and its sigmas.
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel

MOST = 8
"""Unknowns."""
R = 0
Z = R + MOST * MOST
ROW = Z + MOST
"""h, then y at ROW + MOST."""
SQUARES = ROW + MOST + 1
COUNT = SQUARES + 1
X = COUNT + 1
SIGMA = X + MOST
SIZE = SIGMA + MOST

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
LEAST = np.float32(1.0e-6)
"""Of the largest diagonal element: below it an unknown does not show in the equations."""
INDEX_MASK = 7


@kernel
def clear_equations(q):
    """Nothing known."""
    for k in range(np.int32(SIZE)):
        q[k] = ZERO


@kernel
def absorb_equation(q, n):
    """The equation in ROW goes into R and z; ROW is used up."""
    for k in range(np.int32(n)):
        b = q[ROW + k]
        if b != ZERO:
            a = q[R + MOST * k + k]
            length = np.float32(math.sqrt(a * a + b * b))
            c = a / length
            s = b / length
            for j in range(np.int32(k), np.int32(n)):
                upper = q[R + MOST * k + j]
                lower = q[ROW + j]
                q[R + MOST * k + j] = c * upper + s * lower
                q[ROW + j] = c * lower - s * upper
            upper = q[Z + k]
            lower = q[ROW + MOST]
            q[Z + k] = c * upper + s * lower
            q[ROW + MOST] = c * lower - s * upper
    q[SQUARES] += q[ROW + MOST] * q[ROW + MOST]
    q[COUNT] += ONE


@kernel
def solve_equations(q, n):
    """x and its sigmas, as the residuals have it; False: an unknown does not show, or too few equations."""
    spare = q[COUNT] - np.float32(np.int32(n))
    largest = ZERO
    least = abs(q[R])
    for k in range(np.int32(n)):
        size = abs(q[R + MOST * k + k])
        largest = max(largest, size)
        least = min(least, size)
    if not spare >= ONE or not least > LEAST * largest:
        return False
    sigma = np.float32(math.sqrt(q[SQUARES] / spare))
    for back in range(np.int32(n)):
        k = (n - 1 - back) & INDEX_MASK
        total = q[Z + k]
        for j in range(np.int32(k + 1), np.int32(n)):
            total -= q[R + MOST * k + j] * q[X + j]
        q[X + k] = total / q[R + MOST * k + k]
    for k in range(np.int32(n)):
        q[SIGMA + k] = sigma * _row_length(q, n, k)
    return True


@kernel
def _row_length(q, n, row):
    """√ of Σ_j (R⁻¹)_{row, j}²: row of the inverse, solved from the left into ROW."""
    total = ZERO
    for j in range(np.int32(row), np.int32(n)):
        value = ONE if j == row else ZERO
        for m in range(np.int32(row), np.int32(j)):
            value -= q[ROW + m] * q[R + MOST * m + j]
        value /= q[R + MOST * j + j]
        q[ROW + j] = value
        total += value * value
    return np.float32(math.sqrt(total))
