"""Reciprocal, quotient and square root of integers, by Newton's method: no division instruction.

    function              argument                      result                      largest error
    reciprocal_mantissa   2³⁰ ≤ m < 2³¹  (½ … 1)        2⁶¹/m, 2³⁰ … 2³¹            1.5 units (1e-9)
    quotient              |a| < 2³¹, 1 ≤ b < 2⁶²        a · 2^bits / b              1.5e-9 of it and 1 unit
    square_root           x < 2⁶²                       ⌊√x⌋; 0 below 0             exact

Starting values are minimax polynomials, of 1 % for the reciprocal and 2.4 % for the reciprocal root; each
Newton step about squares the error.
"""

import numpy as np

from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import in_q, leading_bit, product, rounded_shift, shifted

RECIPROCAL_0 = in_q(140 / 33, 28)
RECIPROCAL_1 = in_q(64 / 11, 28)
RECIPROCAL_2 = in_q(256 / 99, 28)
ROOT_0 = in_q(2.67071063, 28)
ROOT_1 = in_q(3.28506795, 28)
ROOT_2 = in_q(1.63843698, 28)
ONE_Q60 = 1 << 60
THREE_Q59 = 3 << 59


@kernel("int64(int64)")
def reciprocal_mantissa(m):
    """1/m in Q30 of m in Q31, ½ ≤ m < 1."""
    y = RECIPROCAL_1 - product(RECIPROCAL_2, m, 31)
    y = (RECIPROCAL_0 - product(y, m, 31)) << 1
    y += product(y, rounded_shift(ONE_Q60 - m * y, 30), 30)
    y += product(y, rounded_shift(ONE_Q60 - m * y, 30), 30)
    return (y << 1) + product(y, rounded_shift(ONE_Q60 - m * y, 30), 29)


@kernel("int64(int64, int64, int64)")
def quotient(a, b, bits):
    """a · 2^bits / b for b ≥ 1 and bits ≤ 31 + ⌊log₂ b⌋."""
    e = leading_bit(b)
    mantissa = b << (30 - e) if e <= 30 else b >> (e - 30)
    bits = min(max(bits - e - 31, np.int64(-62)), np.int64(62))
    return shifted(a * reciprocal_mantissa(mantissa), bits)


@kernel("int64(int64)")
def square_root(x):
    """⌊√x⌋ for x < 2⁶²."""
    if x <= 0:
        return np.int64(0)
    e = (leading_bit(x) >> 1) << 1
    m = x << (30 - e) if e <= 30 else x >> (e - 30)  # Q32, ¼ ≤ m < 1
    y = ROOT_1 - product(ROOT_2, m, 32)
    y = (ROOT_0 - product(y, m, 32)) << 1  # 1/√m in Q29
    for _ in range(np.int32(3)):
        rest = rounded_shift(THREE_Q59 - product(m, y, 31) * y, 30)
        y = product(y, rest, 30)
    root = shifted(product(m, y, 31), (e >> 1) - 29)
    for _ in range(np.int32(6)):
        if root * root > x:
            root -= 1
        elif (root + 1) * (root + 1) <= x:
            root += 1
    return root
