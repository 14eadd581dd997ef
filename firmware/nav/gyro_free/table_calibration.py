"""Bias, scale factor and misalignment of three axes from positions or turns of a table.

Each axis reads y = h · r + b with the reference r (gravity less, Earth rate, or the rate of the table, in
axes of the body) known: four unknowns an axis, h its row of I + K + Θ. Twelve positions (the document's 3.7
to 3.12 solve the same from part of the readings) and the turns of a rate table give the same equations. From
H and b come what the sensor needs, truth = M y − c with M = H⁻¹, c = M b.

Twelve positions at rest hold Earth rate only (15°/h): the sigmas tell that the rate part is not to be had
from them with such accelerometers. Turn the table instead.
"""

import numpy as np

from firmware.nav.gyro_free.least_squares import (
    MOST,
    ROW,
    SIGMA,
    SIZE,
    X,
    absorb_equation,
    clear_equations,
    solve_equations,
)
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
LEAST = np.float32(1.0e-3)
THREE = np.int32(3)
UNKNOWNS = 4
AXIS_SIZE = SIZE
MATRIX = 0
"""Result: M row by row, c; then H row by row, b, and the sigmas of both (9 and 3)."""
BIAS = 9
RESPONSE = 12
OFFSET = 21
SIGMA_RESPONSE = 24
SIGMA_OFFSET = 33
RESULT_SIZE = 36


@kernel("void(float32[::1])")
def begin_positions(q):
    """No position yet; `q` has SIZE places for one axis, and is wanted for each of three."""
    clear_equations(q)


@kernel("void(float32[::1], float32, float32, float32, float32)")
def take_position(q, x, y, z, read):
    """One axis has read `read` (mean at rest, or while turning steadily) with the reference (x, y, z)."""
    q[ROW] = x
    q[ROW + 1] = y
    q[ROW + 2] = z
    q[ROW + 3] = ONE
    q[ROW + MOST] = read
    absorb_equation(q, UNKNOWNS)


@kernel("boolean(float32[::1], float32[::1], float32[::1], float32[::1])")
def solve_positions(qx, qy, qz, result):
    """Calibration of three axes to `result` (places above); False: positions do not tell all."""
    if not (
        solve_equations(qx, UNKNOWNS) and solve_equations(qy, UNKNOWNS) and solve_equations(qz, UNKNOWNS)
    ):
        return False
    _keep_axis(qx, result, 0)
    _keep_axis(qy, result, 1)
    _keep_axis(qz, result, 2)
    return _invert(result)


@kernel
def _keep_axis(q, result, axis):
    for k in range(THREE):
        result[RESPONSE + 3 * axis + k] = q[X + k]
        result[SIGMA_RESPONSE + 3 * axis + k] = q[SIGMA + k]
    result[OFFSET + axis] = q[X + 3]
    result[SIGMA_OFFSET + axis] = q[SIGMA + 3]


@kernel
def _invert(result):
    """M = H⁻¹ by cofactors, c = M b."""
    h = RESPONSE
    a, b, c = result[h], result[h + 1], result[h + 2]
    d, e, f = result[h + 3], result[h + 4], result[h + 5]
    g, i, j = result[h + 6], result[h + 7], result[h + 8]
    ca = e * j - f * i
    cb = f * g - d * j
    cc = d * i - e * g
    determinant = a * ca + b * cb + c * cc
    if not abs(determinant) > LEAST:
        return False
    per = ONE / determinant
    result[MATRIX] = ca * per
    result[MATRIX + 1] = (c * i - b * j) * per
    result[MATRIX + 2] = (b * f - c * e) * per
    result[MATRIX + 3] = cb * per
    result[MATRIX + 4] = (a * j - c * g) * per
    result[MATRIX + 5] = (c * d - a * f) * per
    result[MATRIX + 6] = cc * per
    result[MATRIX + 7] = (b * g - a * i) * per
    result[MATRIX + 8] = (a * e - b * d) * per
    for k in range(THREE):
        total = ZERO
        for m in range(THREE):
            total += result[MATRIX + 3 * k + m] * result[OFFSET + m]
        result[BIAS + k] = total
    return True
