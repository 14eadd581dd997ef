"""The places of `..layout` and the Q format of each number in the int32 array `s`.

value = integer · 2^(−Q). The ranges behind the choice stand in docs/fixed-point.md. Angles that stand for
themselves are binary (a turn is 2³²). What `iterate` needs of the period is kept in three scalings.
"""

from firmware.nav.attitude.layout import *  # noqa: F403
from firmware.nav.attitude.layout import (
    ACCEL_BIAS,
    ACCEL_SCALE,
    C_B_S,
    C_N_B,
    EARTH_RATE_D,
    EARTH_RATE_N,
    FIELD,
    FIELD_SCALE,
    FORCE,
    GRAVITY,
    GYRO_BIAS,
    GYRO_SCALE,
    LEAST_FIELD,
    MOST_FIELD,
    OMEGA,
    PER_COS_LATITUDE,
    PER_MERIDIAN_RADIUS,
    PER_NORMAL_RADIUS,
    PERIOD,
    QUATERNION,
    REST_FORCE,
    REST_RATE,
    TAN_LATITUDE,
    VELOCITY,
)

HALF_PERIOD = 82
"""T/2, s."""
SIXTH_PERIOD = 83
"""T/6, s."""
TURN_PERIOD = 84
"""T/2 in binary units of angle for 2⁻²⁷ rad/s."""

Q_UNIT = 30
"""Quaternion, direction cosines, sine, cosine."""
Q_FINE = 38
"""The quaternion together with QUATERNION_REST."""
Q_RATE = 27
Q_FORCE = 22
Q_FIELD = 41
Q_VELOCITY = 21
Q_INCREMENT = 27
"""Velocity increments of an iteration, gravity."""
Q_ANGLE = 32
"""Angle increments of an iteration, rad."""
Q_EARTH_RATE = 42
Q_TANGENT = 20
Q_PER_RADIUS = 53
Q_PERIOD = 36
Q_HALF_PERIOD = 37
Q_SIXTH_PERIOD = 36
Q_TURN_PERIOD = 35
Q_DISTANCE = 26
"""Metres of an iteration."""
Q_REST = 60
"""What is left of latitude and longitude, rad."""
Q_GYRO_SCALE = 40
Q_ACCEL_SCALE = 35
Q_FIELD_SCALE = 54
SCALE_SHIFT = 13
"""From a scaled count to the quantity: Q_…_SCALE less the Q of the quantity."""

FORMATS = (
    (QUATERNION, 4, Q_UNIT),
    (VELOCITY, 3, Q_VELOCITY),
    (GYRO_BIAS, 3, Q_RATE),
    (OMEGA, 9, Q_RATE),
    (FORCE, 9, Q_FORCE),
    (FIELD, 3, Q_FIELD),
    (C_N_B, 9, Q_UNIT),
    (EARTH_RATE_N, 1, Q_EARTH_RATE),
    (EARTH_RATE_D, 1, Q_EARTH_RATE),
    (PER_MERIDIAN_RADIUS, 1, Q_PER_RADIUS),
    (PER_NORMAL_RADIUS, 1, Q_PER_RADIUS),
    (TAN_LATITUDE, 1, Q_TANGENT),
    (PER_COS_LATITUDE, 1, Q_TANGENT),
    (GRAVITY, 1, Q_INCREMENT),
    (PERIOD, 1, Q_PERIOD),
    (C_B_S, 9, Q_UNIT),
    (GYRO_SCALE, 1, Q_GYRO_SCALE),
    (ACCEL_SCALE, 1, Q_ACCEL_SCALE),
    (FIELD_SCALE, 1, Q_FIELD_SCALE),
    (ACCEL_BIAS, 3, Q_FORCE),
    (REST_RATE, 1, Q_RATE),
    (REST_FORCE, 1, Q_FORCE),
    (LEAST_FIELD, 1, Q_FIELD),
    (MOST_FIELD, 1, Q_FIELD),
    (HALF_PERIOD, 1, Q_HALF_PERIOD),
    (SIXTH_PERIOD, 1, Q_SIXTH_PERIOD),
    (TURN_PERIOD, 1, Q_TURN_PERIOD),
)
"""Place in `s`, how many, Q. DECLINATION and GIVEN_YAW are binary angles; other places are not used."""
