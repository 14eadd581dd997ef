import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from firmware.numerics.fixed_position import (
    FULL_TURN,
    HALF_TURN,
    QUARTER_TURN,
    add_to_latitude,
    add_to_longitude,
    metres_east,
    metres_north,
    nanodegrees_of_units,
    radians_of_units,
    stop_at_pole,
    units_of_nanodegrees,
    units_of_radians,
    wrap_longitude,
)

# 60 digits, published.
PI = Fraction(314159265358979323846264338327950288419716939937510582097494, 10**59)
UNITS_PER_NANODEGREE = PI * 2**40 / (180 * 10**9)
EARTH_RADIUS = 6_378_137.0

nanodegrees = st.integers(-180 * 10**9, 180 * 10**9)
latitudes = st.integers(-int(QUARTER_TURN), int(QUARTER_TURN))
longitudes = st.integers(-int(HALF_TURN), int(HALF_TURN) - 1)


def test_constants_are_those_of_a_circle():
    assert [int(x) for x in (QUARTER_TURN, HALF_TURN, FULL_TURN)] == [
        round(PI / 2 * 2**40),
        round(PI * 2**40),
        round(2 * PI * 2**40),
    ]


@given(nanodegrees)
@example(180 * 10**9)
@example(-180 * 10**9)
@example(90 * 10**9)
def test_units_of_nanodegrees_are_within_half_a_unit(angle):
    assert abs(units_of_nanodegrees(angle) - angle * UNITS_PER_NANODEGREE) <= Fraction(51, 100)


@given(nanodegrees)
@example(180 * 10**9)
@example(-180 * 10**9)
def test_every_nanodegree_comes_back(angle):
    assert nanodegrees_of_units(units_of_nanodegrees(angle)) == angle


@given(st.integers(-int(FULL_TURN), int(FULL_TURN)))
def test_nanodegrees_of_any_unit(units):
    assert abs(nanodegrees_of_units(units) - units / UNITS_PER_NANODEGREE) <= Fraction(56, 100)


def test_resolution_is_below_six_micrometres():
    step = metres_north(1, 0, EARTH_RADIUS)
    assert 0.0 < step < 6e-6
    assert metres_north(int(QUARTER_TURN), int(QUARTER_TURN) - 1, EARTH_RADIUS) == step


def test_float32_radians_would_resolve_decimetres_only():
    """Why positions are integers: what one step does to 48° in float32, and to the same in units."""
    radians = np.float32(math.radians(48.0))
    step = np.float32(0.01 / EARTH_RADIUS)
    assert radians + step == radians
    latitude = units_of_nanodegrees(48 * 10**9)
    assert metres_north(add_to_latitude(latitude, step), latitude, EARTH_RADIUS) == pytest.approx(
        0.01, abs=3e-6
    )


def test_a_thousand_small_steps_add_up():
    """1000 steps of 5 cm: what rounding each step to a unit does stays below its bound of 2.9 mm."""
    step = np.float32(0.05 / EARTH_RADIUS)
    latitude = start = units_of_nanodegrees(-33 * 10**9)
    for _ in range(1000):
        latitude = add_to_latitude(latitude, step)
    assert metres_north(latitude, start, EARTH_RADIUS) == pytest.approx(50.0, abs=2.9e-3)


@given(st.floats(-0.5, 0.5, width=32))
def test_units_of_radians_are_rounded_halves_away_from_zero(angle):
    exact = Fraction(float(angle)) * 2**40
    nearest = math.floor(abs(exact) + Fraction(1, 2)) * (1 if exact >= 0 else -1)
    assert units_of_radians(angle) == nearest


def test_not_a_number_moves_nothing():
    assert add_to_latitude(12345, math.nan) == 12345
    assert add_to_longitude(12345, math.nan) == 12345


@given(latitudes, st.floats(-0.5, 0.5, width=32))
def test_latitude_stops_at_the_poles(latitude, angle):
    got = add_to_latitude(latitude, angle)
    assert got == max(-int(QUARTER_TURN), min(int(QUARTER_TURN), latitude + units_of_radians(angle)))


@pytest.mark.parametrize("sign", [1, -1])
def test_beyond_a_pole_is_the_pole(sign):
    assert add_to_latitude(sign * (int(QUARTER_TURN) - 3), sign * 1e-6) == sign * int(QUARTER_TURN)
    assert nanodegrees_of_units(stop_at_pole(sign * int(FULL_TURN))) == sign * 90 * 10**9


@given(longitudes, st.floats(-0.5, 0.5, width=32))
def test_longitude_wraps(longitude, angle):
    got = add_to_longitude(longitude, angle)
    assert -int(HALF_TURN) <= got < int(HALF_TURN)
    assert (got - longitude - units_of_radians(angle)) % int(FULL_TURN) == 0


def test_180_degrees_east_is_180_degrees_west():
    assert nanodegrees_of_units(wrap_longitude(units_of_nanodegrees(180 * 10**9))) == -180 * 10**9
    assert nanodegrees_of_units(wrap_longitude(units_of_nanodegrees(-180 * 10**9))) == -180 * 10**9


@given(longitudes, st.integers(-10_000_000, 10_000_000))
def test_distance_east_goes_the_shorter_way(longitude, step):
    other = wrap_longitude(longitude + step)
    want = step * 2.0**-40 * EARTH_RADIUS
    assert metres_east(other, longitude, EARTH_RADIUS) == pytest.approx(want, rel=3e-7)


@given(latitudes, latitudes)
def test_distance_north(latitude, origin):
    want = (latitude - origin) * 2.0**-40 * EARTH_RADIUS
    assert metres_north(latitude, origin, EARTH_RADIUS) == pytest.approx(want, rel=3e-7)


@given(longitudes)
def test_angle_for_sines_is_the_nearest_float32(longitude):
    assert radians_of_units(longitude) == np.float32(longitude * 2.0**-40)
