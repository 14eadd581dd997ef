"""Rounding, saturation, quotient and roots of fixed point against Python's integers, which never overflow."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from firmware.numerics.fixed.arithmetic import (
    LARGEST,
    SMALLEST,
    in_q,
    leading_bit,
    limited,
    product,
    rounded_shift,
    saturated,
    shifted,
)
from firmware.numerics.fixed.roots import quotient, reciprocal_mantissa, square_root

words = st.integers(SMALLEST, LARGEST)
wide = st.integers(-(2**62) + 1, 2**62 - 1)


def halves_up(value: Fraction) -> int:
    return math.floor(value + Fraction(1, 2))


@given(wide, st.integers(1, 62))
@example(-1, 1)
@example(1, 1)
@example(2**62 - 1, 62)
def test_shift_rounds_halves_up(x, bits):
    assert rounded_shift(x, bits) == halves_up(Fraction(x, 2**bits))


@given(words, words, st.integers(1, 62))
def test_product_rounds_halves_up(a, b, bits):
    if abs(a * b) < 2**62:
        assert product(a, b, bits) == halves_up(Fraction(a * b, 2**bits))


@given(st.integers(-(2**31), 2**31), st.integers(-30, 30))
def test_shift_both_ways(x, bits):
    assert shifted(x, bits) == halves_up(x * Fraction(2) ** bits)


@given(wide)
@example(LARGEST)
@example(LARGEST + 1)
@example(SMALLEST)
@example(SMALLEST - 1)
def test_saturation_is_the_nearest_end_and_is_counted(x):
    counters = np.zeros(3, np.int64)
    assert saturated(x, counters, 1) == min(max(x, SMALLEST), LARGEST)
    assert counters.tolist() == [0, int(not SMALLEST <= x <= LARGEST), 0]


@given(wide, st.integers(0, 2**40))
def test_limit_is_symmetric_and_counted(x, limit):
    counters = np.zeros(2, np.int64)
    assert limited(x, limit, counters, 0) == min(max(x, -limit), limit)
    assert counters.tolist() == [int(abs(x) > limit), 0]


@given(st.integers(1, 2**63 - 1))
@example(1)
@example(2**63 - 1)
def test_leading_bit(x):
    assert leading_bit(x) == x.bit_length() - 1


def test_leading_bit_of_powers_and_of_nothing():
    for k in range(63):
        assert leading_bit(2**k) == k
        assert leading_bit(2 ** (k + 1) - 1) == k
    assert leading_bit(0) == 0


def test_constants_that_do_not_fit_are_refused():
    assert in_q(0.5, 30) == 2**29
    assert in_q(-2.0, 30) == SMALLEST
    with pytest.raises(ValueError, match=r"2\.0 does not fit into Q30: ±2"):
        in_q(2.0, 30)


@given(st.integers(2**30, 2**31 - 1))
@example(2**30)
@example(2**31 - 1)
def test_reciprocal_within_its_claim(m):
    assert abs(reciprocal_mantissa(m) - Fraction(2**61, m)) <= 1.5


def test_reciprocal_densely():
    for m in range(2**30, 2**31, 200_003):
        assert abs(reciprocal_mantissa(m) - 2**61 / m) <= 1.5


@given(words, st.integers(1, 2**62 - 1), st.integers(0, 31))
def test_quotient_within_its_claim(a, b, above):
    bits = b.bit_length() - 1 + above
    exact = Fraction(a * 2**bits, b)
    assert abs(quotient(a, b, bits) - exact) <= 1 + abs(exact) * Fraction(15, 10**10)


@given(st.integers(0, 2**62 - 1))
@example(0)
@example(1)
@example(2**62 - 1)
def test_root_is_exact(x):
    assert square_root(x) == math.isqrt(x)


@given(st.integers(1, 2**31 - 1), st.sampled_from([-1, 0, 1]))
def test_root_around_squares_is_exact(root, beside):
    assert square_root(root * root + beside) == math.isqrt(root * root + beside)


def test_root_of_small_numbers_powers_and_negatives():
    for x in range(5000):
        assert square_root(x) == math.isqrt(x)
    for k in range(62):
        for beside in (-1, 0, 1):
            assert square_root(2**k + beside) == math.isqrt(2**k + beside)
    assert square_root(-1) == 0
    assert square_root(2**62 + 2**32) == math.isqrt(2**62 + 2**32)
