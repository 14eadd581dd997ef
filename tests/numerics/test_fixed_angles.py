"""Sine, cosine, arc tangent and arc sine of binary angles against the C library in float64."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from firmware.numerics.fixed.angles import (
    FULL_TURN,
    HALF_TURN,
    QUARTER_TURN,
    angle_of_radians,
    arc_sine,
    arc_tangent2,
    nanoradians,
    sine_cosine,
    wrap,
)

UNIT = math.pi / 2.0**31
"""rad of a binary unit."""
angles = st.integers(-HALF_TURN, HALF_TURN - 1)
coordinates = st.integers(-(2**61) + 1, 2**61 - 1)


def apart(a: float, b: float) -> float:
    """Units between two angles, the shorter way round."""
    return abs((a - b + HALF_TURN) % FULL_TURN - HALF_TURN)


def sine_error(angle: int) -> float:
    found = sine_cosine(angle)
    exact = math.sin(angle * UNIT), math.cos(angle * UNIT)
    return max(abs(found[k] - exact[k] * 2.0**30) for k in range(2))


@given(angles)
@example(-HALF_TURN)
@example(HALF_TURN - 1)
def test_sine_and_cosine_within_their_claim(angle):
    assert sine_error(angle) <= 1.0


def test_sine_and_cosine_densely_and_around_octants():
    for angle in range(-HALF_TURN, HALF_TURN, 1_000_003):
        assert sine_error(angle) <= 1.0
    for octant in range(-4, 4):
        for beside in range(-50, 50):
            assert sine_error(octant * (QUARTER_TURN >> 1) + beside) <= 1.0


def test_sine_and_cosine_of_quarter_turns_are_exact():
    one = 2**30
    exact = {0: (0, one), QUARTER_TURN: (one, 0), -HALF_TURN: (0, -one), -QUARTER_TURN: (-one, 0)}
    for angle, values in exact.items():
        assert sine_cosine(angle) == values


@given(angles)
def test_sine_is_odd_and_cosine_even(angle):
    if angle > -HALF_TURN and angle % QUARTER_TURN != QUARTER_TURN // 2:
        (s, c), (minus_s, same_c) = sine_cosine(angle), sine_cosine(-angle)
        assert abs(s + minus_s) <= 1
        assert abs(c - same_c) <= 1


@given(st.integers(-(2**40), 2**40))
def test_angles_wrap_as_32_bit_numbers_do(angle):
    assert wrap(angle) == int(np.array(angle).astype(np.int32))
    assert sine_cosine(angle) == sine_cosine(wrap(angle))


@given(coordinates, coordinates)
@example(1, 0)
@example(-1, 0)
@example(0, -1)
@example(1, 1)
@example(-1, -1)
@example(2**61 - 1, 1)
@example(1, -(2**61) + 1)
def test_arc_tangent_within_its_claim(y, x):
    assert apart(arc_tangent2(y, x), math.atan2(y, x) / UNIT) <= 1.6
    assert -HALF_TURN <= arc_tangent2(y, x) < HALF_TURN


def test_arc_tangent_densely():
    for k in range(20_000):
        angle = -math.pi + 2.0 * math.pi * k / 20_000
        for length in (2.0**24, 2.0**30, 2.0**60):
            y, x = round(length * math.sin(angle)), round(length * math.cos(angle))
            assert apart(arc_tangent2(y, x), math.atan2(y, x) / UNIT) <= 1.6


def test_arc_tangent_on_the_axes():
    assert arc_tangent2(0, 0) == 0
    assert arc_tangent2(0, 5) == 0
    assert arc_tangent2(5, 0) == QUARTER_TURN
    assert arc_tangent2(0, -5) == -HALF_TURN
    assert arc_tangent2(-5, 0) == -QUARTER_TURN


@given(angles)
def test_arc_tangent_finds_the_angle_of_sine_and_cosine(angle):
    """A unit of Q30 across is 0.64 units of angle: one of each, and the arc tangent's own."""
    s, c = sine_cosine(angle)
    assert apart(arc_tangent2(s, c), angle) <= 0.64 * math.sqrt(2.0) + 1.6


def arc_sine_error(x: int) -> float:
    return abs(arc_sine(x) - math.asin(x / 2.0**30) / UNIT)


@given(st.integers(-(2**30), 2**30))
@example(2**30)
@example(-(2**30))
@example(2**30 - 1)
def test_arc_sine_within_its_claim(x):
    assert arc_sine_error(x) <= 1.6


def test_arc_sine_densely_and_near_its_ends():
    for x in range(-(2**30), 2**30, 200_003):
        assert arc_sine_error(x) <= 1.6
    for beside in range(200):
        assert arc_sine_error(2**30 - beside) <= 1.6
        assert arc_sine_error(beside - 2**30) <= 1.6


@given(st.integers(2**30, 2**40))
def test_arc_sine_beyond_one_is_a_quarter_turn(x):
    assert arc_sine(x) == QUARTER_TURN
    assert arc_sine(-x) == -QUARTER_TURN


@given(st.integers(-FULL_TURN, FULL_TURN))
def test_nanoradians(angle):
    assert nanoradians(angle) == pytest.approx(angle * UNIT * 1e9, abs=0.51 + abs(angle) * 2e-10)


@given(st.floats(-20.0, 20.0))
def test_angle_of_radians_wraps(angle):
    found = angle_of_radians(angle)
    assert -HALF_TURN <= found < HALF_TURN
    assert apart(found, angle / UNIT) <= 0.51
