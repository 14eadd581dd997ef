"""Latitude and longitude as int64 in units of 2⁻⁴⁰ rad: 5.8 µm on the ground, everywhere.

A latitude in radians in float32 resolves 0.4 to 0.8 m only. Here positions are integers; what is small (the
increment of one step, the distance between two positions) is float32, and the two meet in this file only.

    π rad = 3 454 217 652 357.64 units;  1 nanodegree = 19.190098068653537 units

Latitude lies in [−90°, 90°] and stops at the poles; longitude lies in [−180°, 180°) and wraps. The full turn
is rounded to whole units (0.27 units, 1.6 µm, once a turn). Conversion from nanodegrees (0.11 mm each)
is within 0.51 units, and every nanodegree comes back as it was.
"""

import numpy as np

from firmware.numerics.dialect import kernel
from firmware.numerics.wide_integers import float32_of_int64, int64_of_float32

UNITS_PER_RADIAN = np.float32(2.0**40)
RADIANS_PER_UNIT = np.float32(2.0**-40)

QUARTER_TURN = np.int64(1727108826179)
HALF_TURN = np.int64(3454217652358)
FULL_TURN = np.int64(6908435304715)

# 1 nanodegree = 19 + 6688481180874 / 2^45 units; 1 unit = 1833464944419 / 2^45 nanodegrees. Each product is
# taken in two parts, of 20 or 21 bits and the rest, so that neither exceeds 63 bits.
WHOLE_UNITS_PER_NANODEGREE = np.int64(19)
UNIT_FRACTION_PER_NANODEGREE = np.int64(6688481180874)
LOW_20_BITS = np.int64(2**20 - 1)
HALF_OF_2_25 = np.int64(2**24)
NANODEGREES_PER_UNIT = np.int64(1833464944419)
LOW_21_BITS = np.int64(2**21 - 1)
HALF_OF_2_24 = np.int64(2**23)


@kernel("int64(int64)")
def units_of_nanodegrees(nanodegrees):
    """Units of an angle within ±1000°, as it stands: neither stopped at a pole nor wrapped."""
    high = (nanodegrees >> 20) * UNIT_FRACTION_PER_NANODEGREE
    low = ((nanodegrees & LOW_20_BITS) * UNIT_FRACTION_PER_NANODEGREE) >> 20
    return nanodegrees * WHOLE_UNITS_PER_NANODEGREE + ((high + low + HALF_OF_2_25) >> 25)


@kernel("int64(int64)")
def nanodegrees_of_units(units):
    """Nearest nanodegrees of an angle within ±360°."""
    high = (units >> 21) * NANODEGREES_PER_UNIT
    low = ((units & LOW_21_BITS) * NANODEGREES_PER_UNIT) >> 21
    return (high + low + HALF_OF_2_24) >> 24


@kernel("float32(int64)")
def radians_of_units(units):
    """The angle in rad as float32: for sines and cosines, not for positions."""
    return float32_of_int64(units) * RADIANS_PER_UNIT


@kernel("int64(float32)")
def units_of_radians(angle):
    """Units of a small angle in rad (float32 resolves a unit up to 1.5e-5 rad, 97 m); 0 for NaN."""
    return int64_of_float32(angle * UNITS_PER_RADIAN)


@kernel("int64(int64)")
def wrap_longitude(units):
    """A longitude within one turn of its range brought into [−180°, 180°)."""
    if units >= HALF_TURN:
        return units - FULL_TURN
    if units < -HALF_TURN:
        return units + FULL_TURN
    return units


@kernel("int64(int64)")
def stop_at_pole(units):
    """A latitude brought into [−90°, 90°]."""
    return min(max(units, -QUARTER_TURN), QUARTER_TURN)


@kernel("int64(int64, float32)")
def add_to_latitude(latitude, angle):
    """Latitude (units) moved north by `angle` rad, |angle| ≤ 0.5."""
    return stop_at_pole(latitude + units_of_radians(angle))


@kernel("int64(int64, float32)")
def add_to_longitude(longitude, angle):
    """Longitude (units) moved east by `angle` rad, |angle| ≤ 0.5."""
    return wrap_longitude(longitude + units_of_radians(angle))


@kernel("float32(int64, int64, float32)")
def metres_north(latitude, origin, meridian_radius):
    """Distance north of `origin` (both in units), with the radius R_M + h in m."""
    return radians_of_units(latitude - origin) * meridian_radius


@kernel("float32(int64, int64, float32)")
def metres_east(longitude, origin, parallel_radius):
    """Distance east of `origin` (both in units) the shorter way round, with (R_N + h) cos φ in m."""
    return radians_of_units(wrap_longitude(longitude - origin)) * parallel_radius
