"""The few functions that the parsers need beyond + − ×: integer square root, sine and cosine in Q30.

    sin(π/2·x) ≈ x·(c₀ − x²(c₁ − x²(c₂ − x²(c₃ − x²(c₄ − x²·c₅))))),  c_k = (π/2)^(2k+1)/(2k+1)!

with 0 ≤ x ≤ 1 in Q30; the terms left out are below 6e-8.
"""

from typing import Final

import numpy as np

from firmware.numerics.dialect import kernel

ONE_Q30: Final = 1 << 30
QUARTER_E5DEG: Final = 9_000_000
PER_E5DEG: Final = 8_006_399_338
"""2³⁰/9e6 in Q26."""
C0: Final = 1_686_629_713
C1: Final = 693_598_668
C2: Final = 85_569_306
C3: Final = 5_026_995
C4: Final = 172_272
C5: Final = 3_864


@kernel
def sine_quarter(x):
    """sin(π/2·x) in Q30 of x in Q30, 0 ≤ x ≤ 1."""
    square = (x * x) >> 30
    value = C4 - ((square * C5) >> 30)
    value = C3 - ((square * value) >> 30)
    value = C2 - ((square * value) >> 30)
    value = C1 - ((square * value) >> 30)
    value = C0 - ((square * value) >> 30)
    return min((x * value) >> 30, np.int64(ONE_Q30))


@kernel
def along(speed, angle_e5deg):
    """speed · cos(angle) in the unit of `speed`, rounded; |speed| < 2³², |angle| ≤ 360°."""
    rest = abs(angle_e5deg)
    quarter = np.int64(0)
    if rest >= 2 * QUARTER_E5DEG:
        rest -= 2 * QUARTER_E5DEG
        quarter += 2
    if rest >= QUARTER_E5DEG:
        rest -= QUARTER_E5DEG
        quarter += 1
    x = (rest * PER_E5DEG) >> 26
    sine = sine_quarter(x if quarter & 1 == 1 else ONE_Q30 - x)
    if quarter == 1 or quarter == 2:
        sine = -sine
    return (speed * sine + (ONE_Q30 >> 1)) >> 30


@kernel
def square_root(x):
    """⌊√x⌋ for 0 ≤ x < 2⁶², bit by bit."""
    root = np.int64(0)
    bit = np.int64(1) << 60
    while bit > 0:
        if x >= root + bit:
            x -= root + bit
            root = (root >> 1) + bit
        else:
            root >>= 1
        bit >>= 2
    return root


@kernel
def hypotenuse(a, b):
    """√(a² + b²), rounded down; |a|, |b| < 2³⁰."""
    return square_root(a * a + b * b)
