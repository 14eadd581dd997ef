import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_error import map_one, map_two, ulp_error

from firmware.numerics.trigonometry import (
    LARGEST_ANGLE,
    arc_sine,
    arc_tangent2,
    cosine,
    sine,
    sine_cosine,
    square_root,
)

# As stated in the module's docstring.
SINE_ULP = 0.95
ARC_TANGENT_ULP = 1.6
ARC_SINE_ULP = 2.0
SQUARE_ROOT_ULP = 0.5

PAIRS = [(sine, np.sin), (cosine, np.cos)]
finite32 = st.floats(width=32, allow_nan=False, allow_infinity=False)


def rng():
    return np.random.Generator(np.random.PCG64(11))


def exact(function, *arguments):
    return function(*(np.asarray(x).astype(np.longdouble) for x in arguments))


def bits(x):
    return struct.pack("<f", x)


@pytest.mark.parametrize(("function", "reference"), PAIRS)
@pytest.mark.parametrize("largest", [0.8, 3.2, 100.0, 8192.0])
def test_sine_and_cosine_densely(function, reference, largest):
    x = rng().uniform(-largest, largest, 150_000).astype(np.float32)
    assert ulp_error(map_one(function, x), exact(reference, x)).max() < SINE_ULP


@pytest.mark.parametrize(("function", "reference"), PAIRS)
def test_sine_and_cosine_of_evenly_spaced_floats(function, reference):
    """All of [π/8, π/2): the whole of the polynomials and one change of the octant."""
    first, last = (struct.unpack("<I", bits(x))[0] for x in (math.pi / 8, math.pi / 2))
    x = np.arange(first, last, 37, dtype=np.uint32).view(np.float32)
    assert ulp_error(map_one(function, x), exact(reference, x)).max() < SINE_ULP


@pytest.mark.parametrize(("function", "reference"), PAIRS)
def test_sine_and_cosine_beside_all_multiples_of_a_quarter_turn(function, reference):
    """Where the reduction cancels most: the result is as small as the error of the angle."""
    k = np.arange(1, 5216)
    nearest = (k * np.longdouble("1.5707963267948966192313216916397514")).astype(np.float32)
    x = np.concatenate(
        [np.nextafter(nearest, np.float32(0.0)), nearest, np.nextafter(nearest, np.float32(1e9))]
    )
    x = x[x <= LARGEST_ANGLE]
    assert ulp_error(map_one(function, x), exact(reference, x)).max() < SINE_ULP


@pytest.mark.parametrize("x", [0.0, -0.0, 1e-45, -1e-45, 1e-40, 1.1754944e-38, 1e-20])
def test_sine_of_tiny_angles_is_the_angle_with_its_sign(x):
    assert bits(sine(x)) == bits(np.float32(x))
    assert cosine(x) == 1.0


@given(st.floats(-8192, 8192, width=32))
def test_sine_is_odd_and_cosine_even(x):
    s, c = sine_cosine(x)
    assert (bits(sine(-x)), bits(cosine(-x))) == (bits(-s), bits(c))
    assert (s, c) == (sine(x), cosine(x))


@given(st.floats(-8192, 8192, width=32))
def test_sine_and_cosine_lie_on_the_circle(x):
    s, c = sine_cosine(x)
    assert abs(s * s + c * c - 1.0) < 3e-7
    assert max(abs(s), abs(c)) <= 1.0


@pytest.mark.parametrize("x", [8193.0, -1e30, math.inf, -math.inf, math.nan])
def test_sine_of_what_cannot_be_reduced_is_nan(x):
    assert math.isnan(sine(x))
    assert math.isnan(cosine(x))


def test_arc_tangent_densely_in_all_quadrants():
    y, x = rng().uniform(-1.0, 1.0, (2, 250_000)).astype(np.float32)
    assert ulp_error(map_two(arc_tangent2, y, x), exact(np.arctan2, y, x)).max() < ARC_TANGENT_ULP


def test_arc_tangent_of_all_magnitudes():
    pattern = rng().integers(0, 2**32, (2, 250_000), dtype=np.uint32).view(np.float32)
    y, x = pattern[:, np.isfinite(pattern).all(axis=0)]
    assert ulp_error(map_two(arc_tangent2, y, x), exact(np.arctan2, y, x)).max() < ARC_TANGENT_ULP


def test_arc_tangent_of_all_pairs_of_special_values_is_that_of_c():
    special = [0.0, -0.0, 1.0, -1.0, 1e-45, -1e-45, 3e38, -3e38, math.inf, -math.inf]
    for y in special:
        for x in special:
            want = math.atan2(np.float32(y), np.float32(x))
            got = arc_tangent2(y, x)
            assert ulp_error(got, want) < ARC_TANGENT_ULP, (y, x)
            assert math.copysign(1.0, got) == math.copysign(1.0, want), (y, x)


@pytest.mark.parametrize(("y", "x"), [(math.nan, 1.0), (1.0, math.nan), (math.nan, math.nan)])
def test_arc_tangent_of_nan_is_nan(y, x):
    assert math.isnan(arc_tangent2(y, x))


@given(finite32, finite32)
def test_arc_tangent_stays_within_half_a_turn(y, x):
    assert abs(arc_tangent2(y, x)) <= np.float32(math.pi)


def test_arc_sine_densely_and_beside_one():
    u = rng()
    x = np.concatenate([u.uniform(-1, 1, 150_000), 1 - 2 ** u.uniform(-25, 0, 50_000)]).astype(np.float32)
    assert ulp_error(map_one(arc_sine, x), exact(np.arcsin, x)).max() < ARC_SINE_ULP


@pytest.mark.parametrize("x", [0.0, -0.0, 1e-45, -1e-40, 1e-20])
def test_arc_sine_of_tiny_numbers_is_the_number(x):
    assert bits(arc_sine(x)) == bits(np.float32(x))


@pytest.mark.parametrize("x", [1.0, 1.0000001, 2.0, math.inf])
def test_arc_sine_stops_at_a_right_angle(x):
    right_angle = np.float32(math.pi / 2)
    assert (arc_sine(x), arc_sine(-x)) == (right_angle, -right_angle)


def test_arc_sine_of_nan_is_nan():
    assert math.isnan(arc_sine(math.nan))


def test_square_root_is_exactly_rounded():
    x = np.abs(rng().integers(0, 2**31, 200_000, dtype=np.uint32).view(np.float32))
    x = x[np.isfinite(x)]
    assert ulp_error(map_one(square_root, x), exact(np.sqrt, x)).max() <= SQUARE_ROOT_ULP


@pytest.mark.parametrize("x", [-1.0, -1e-45, -math.inf, math.nan])
def test_square_root_of_a_negative_number_is_nan(x):
    assert math.isnan(square_root(x))


def test_square_root_keeps_the_sign_of_zero():
    assert bits(square_root(-0.0)) == bits(-0.0)
