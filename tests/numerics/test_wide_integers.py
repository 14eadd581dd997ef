import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from firmware.numerics.wide_integers import float32_of_int64, int64_of_float32


@given(st.integers(-(2**48) + 1, 2**48 - 1))
@example(2**24 + 1)
@example(-(2**24) - 1)
@example(2**25 + 2)
@example(2**48 - 1)
def test_float32_of_int64_is_the_nearest(value):
    assert float32_of_int64(value) == np.float32(value)


@given(st.floats(-(2.0**53), 2.0**53, width=32))
@example(0.5)
@example(-0.5)
@example(1.5)
@example(2.5)
@example(8388609.0)
@example(float(np.nextafter(np.float32(0.5), np.float32(0.0))))
def test_int64_of_float32_is_the_nearest_with_halves_away_from_zero(x):
    nearest = math.floor(abs(Fraction(float(x))) + Fraction(1, 2))
    assert int64_of_float32(x) == (nearest if x >= 0 else -nearest)


@pytest.mark.parametrize(("x", "want"), [(math.inf, 2**53), (-3e38, -(2**53)), (math.nan, 0)])
def test_int64_of_float32_saturates(x, want):
    assert int64_of_float32(x) == want
