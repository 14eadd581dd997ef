"""Deviation of the compass: 24 headings, 15° apart, by least squares; or from the ellipse of its fields.

    Δβ = A + B sin β + C cos β + D sin 2β + E cos 2β,     β_true = β − Δβ(β)            (3.15, 3.16)

β is what the compass shows, Δβ = β − true. Hard iron makes B and C, soft iron D and E (and A).

Ellipse: turned through a circle, the horizontal field (x, y) runs on an ellipse about the hard iron,

    a x² + b xy + c y² + d x + e y = 1

and the field of the Earth is the circle that soft iron M = S⁻¹ and hard iron c made it of: m = S (m_raw − c),
S = √Q symmetric with Q the matrix of the ellipse (a, b/2; b/2, c) normed to determinant 1. Rotations of soft
iron do not show in it; they belong to the mounting (A). Fields in units near 1.
"""

import math

import numpy as np

from firmware.nav.gyro_free.least_squares import (
    MOST,
    ROW,
    X,
    absorb_equation,
    clear_equations,
    solve_equations,
)
from firmware.numerics.dialect import kernel
from firmware.numerics.trigonometry import sine_cosine

ONE = np.float32(1.0)
TWO = np.float32(2.0)
FOUR = np.float32(4.0)
HALF = np.float32(0.5)
ZERO = np.float32(0.0)
PI = np.float32(3.14159265358979)
TWO_PI = np.float32(6.28318530717959)
COEFFICIENTS = 5
SOFT = 0
"""Result of the ellipse: S (xx, xy, yy), then hard iron (x, y)."""
HARD = 3
ELLIPSE_SIZE = 5


@kernel("void(float32[::1])")
def begin_calibration(q):
    """No reading yet; `q` has least_squares.SIZE places."""
    clear_equations(q)


@kernel("void(float32[::1], float32, float32)")
def take_heading(q, shown, true):
    """The compass shows `shown` when the table stands at `true` (rad, magnetic)."""
    s, c = sine_cosine(shown)
    q[ROW] = ONE
    q[ROW + 1] = s
    q[ROW + 2] = c
    q[ROW + 3] = TWO * s * c
    q[ROW + 4] = c * c - s * s
    difference = shown - true
    if difference >= PI:
        difference -= TWO_PI
    if difference < -PI:
        difference += TWO_PI
    q[ROW + MOST] = difference
    absorb_equation(q, COEFFICIENTS)


@kernel("boolean(float32[::1])")
def solve_deviation(q):
    """A … E (rad) to least_squares.X, their sigmas to SIGMA; False: headings too few or all alike."""
    return solve_equations(q, COEFFICIENTS)


@kernel("void(float32[::1], float32, float32)")
def take_field(q, x, y):
    """A horizontal field as measured on the level."""
    q[ROW] = x * x
    q[ROW + 1] = x * y
    q[ROW + 2] = y * y
    q[ROW + 3] = x
    q[ROW + 4] = y
    q[ROW + MOST] = ONE
    absorb_equation(q, COEFFICIENTS)


@kernel("boolean(float32[::1], float32[::1])")
def solve_ellipse(q, result):
    """S and the hard iron to `result`; False: no ellipse."""
    if not solve_equations(q, COEFFICIENTS):
        return False
    a = q[X]
    half_b = HALF * q[X + 1]
    c = q[X + 2]
    determinant = a * c - half_b * half_b
    if not determinant > ZERO:
        return False
    d = q[X + 3]
    e = q[X + 4]
    result[HARD] = (half_b * e - c * d) / (TWO * determinant)
    result[HARD + 1] = (half_b * d - a * e) / (TWO * determinant)
    sign = ONE if a > ZERO else -ONE
    norm = sign / np.float32(math.sqrt(determinant))
    a *= norm
    half_b *= norm
    c *= norm
    # square root of a symmetric 2 × 2 matrix of determinant 1: (Q + I) / √(trace + 2)
    per_root = ONE / np.float32(math.sqrt(a + c + TWO))
    result[SOFT] = (a + ONE) * per_root
    result[SOFT + 1] = half_b * per_root
    result[SOFT + 2] = (c + ONE) * per_root
    return True
