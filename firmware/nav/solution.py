"""What navigation gives out: the solution, its covariance, innovations, biases and status.

Error definition, for whoever scores: errors are truth minus solution; δr and δv in NED (m, m/s); φ in NED
(rad)
with C_n_b(true) = (I + [φ×]) C_n_b(solution), so φ is the vector part of 2 q_true ⊗ q_solution*. The
sigmas of
attitude are those of φ north, east, down. Before navigation begins the position is that of the last fix,
carried on by its velocity, and what is not known has a sigma of its whole range.
"""

import math

import numpy as np

from firmware.nav import flags as fl
from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav import tuning as cfg
from firmware.nav.covariance import element
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import (
    add_to_latitude,
    add_to_longitude,
    nanodegrees_of_units,
    radians_of_units,
)
from firmware.numerics.quaternion import euler_of_quaternion
from firmware.numerics.trigonometry import sine_cosine
from firmware.numerics.wide_integers import float32_of_int64

ZERO = np.float32(0.0)
TWO = np.float32(2.0)
PI = np.float32(3.14159265358979)
UNKNOWN_POSITION = np.float32(1.0e7)
UNKNOWN_VELOCITY = np.float32(1.0e3)
LEVEL_SIGMA = np.float32(0.05)
SECONDS_PER_NS = np.float32(1.0e-9)
PER_EARTH_RADIUS = np.float32(1.0 / 6.37e6)
LEAST_COS = np.float32(1.0e-3)
ONE = np.int64(1)
THREE = np.int32(3)

# The float32 part of a solution record …
HEIGHT = 0
VELOCITY = 1
YAW = 4
PITCH = 5
ROLL = 6
OMEGA_B = 7
SIGMA_POSITION = 10
SIGMA_VELOCITY = 13
SIGMA_ATTITUDE = 16
SOLUTION_FLOATS = 19
# … and its int64 part
TIME_NS = 0
LAT_NANODEG = 1
LON_NANODEG = 2
MODE = 3
FLAGS = 4
SOLUTION_INTEGERS = 5

COVARIANCE_FLOATS = 45
BIAS_FLOATS = 18
"""b_g 3, b_a 3, mounting yaw and pitch, latency; then the sigma of each."""
INNOVATION_FLOATS = 12
"""Innovations 6 (position NED; velocity NED, or along and across the course), then √S of each."""


@kernel("void(float32[::1], int64[::1], float32[::1], int64[::1])")
def solution(f, i, floats, integers):
    """Fill a solution record (places above): position, velocity, attitude, rate and their sigmas now."""
    mode = i[at.MODE]
    integers[TIME_NS] = i[at.TIME]
    for k in range(THREE):
        floats[OMEGA_B + k] = f[at.OMEGA_B + k]
    if mode == fl.NAVIGATING:
        _navigated(f, i, floats, integers)
    else:
        _before_navigation(f, i, floats, integers)
    integers[FLAGS] = _flags(f, i, floats)
    dead = i[at.TIME] - i[at.GOOD_SAMPLE_TIME] > 0
    uncertain = (integers[FLAGS] >> fl.POSITION_UNCERTAIN) & 1 != 0
    if mode == fl.NAVIGATING and (dead or uncertain or _is_contradicted(i)):
        mode = np.int64(fl.DEGRADED)
    integers[MODE] = mode


@kernel
def _is_contradicted(i):
    """Position and velocity of the receiver have both been refused for a while: one side is wrong, and
    nothing here tells which."""
    since = max(i[at.POSITION_REFUSED_SINCE], i[at.VELOCITY_REFUSED_SINCE])
    refused = min(i[at.POSITION_REFUSED_SINCE], i[at.VELOCITY_REFUSED_SINCE]) != at.NEVER
    return refused and i[at.TIME] - since > fl.HOLD_NS


@kernel
def _navigated(f, i, floats, integers):
    integers[LAT_NANODEG] = nanodegrees_of_units(i[at.LATITUDE])
    integers[LON_NANODEG] = nanodegrees_of_units(i[at.LONGITUDE])
    floats[HEIGHT] = f[at.HEIGHT]
    q = at.QUATERNION
    yaw, pitch, roll = euler_of_quaternion(f[q], f[q + 1], f[q + 2], f[q + 3])
    floats[YAW] = yaw
    floats[PITCH] = pitch
    floats[ROLL] = roll
    for k in range(THREE):
        floats[VELOCITY + k] = f[at.VELOCITY + k]
        floats[SIGMA_POSITION + k] = _sigma(f, at.X_POSITION + k)
        floats[SIGMA_VELOCITY + k] = _sigma(f, at.X_VELOCITY + k)
        floats[SIGMA_ATTITUDE + k] = _sigma(f, at.X_ATTITUDE + k)


@kernel
def _before_navigation(f, i, floats, integers):
    fixed = i[at.FIX_TIME] != at.NEVER
    age = i[at.TIME] - i[at.FIX_TIME]
    lost = not fixed or age > i[cfg.GNSS_LOST_NS]
    dt = ZERO if lost else float32_of_int64(age) * SECONDS_PER_NS
    latitude = i[at.FIX_LATITUDE]
    _, cos_lat = sine_cosine(radians_of_units(latitude))
    angle = dt * PER_EARTH_RADIUS
    east = f[at.GNSS_FIX + 2] * angle / max(cos_lat, LEAST_COS)
    integers[LAT_NANODEG] = nanodegrees_of_units(add_to_latitude(latitude, f[at.GNSS_FIX + 1] * angle))
    integers[LON_NANODEG] = nanodegrees_of_units(add_to_longitude(i[at.FIX_LONGITUDE], east))
    floats[HEIGHT] = f[at.GNSS_FIX] - f[at.GNSS_FIX + 3] * dt
    for k in range(THREE):
        floats[VELOCITY + k] = f[at.GNSS_FIX + 1 + k]
        variance = f[at.GNSS_FIX + 5] if k == 2 else f[at.GNSS_FIX + 4]
        floats[SIGMA_POSITION + k] = np.float32(math.sqrt(variance)) if fixed else UNKNOWN_POSITION
        floats[SIGMA_VELOCITY + k] = np.float32(math.sqrt(f[at.GNSS_FIX + 6])) if fixed else UNKNOWN_VELOCITY
        floats[SIGMA_ATTITUDE + k] = PI
        floats[YAW + k] = ZERO
    if i[at.MODE] == fl.WAITING_FOR_HEADING:
        q = at.QUATERNION
        _, pitch, roll = euler_of_quaternion(f[q], f[q + 1], f[q + 2], f[q + 3])
        floats[PITCH] = pitch
        floats[ROLL] = roll
        floats[SIGMA_ATTITUDE] = LEVEL_SIGMA
        floats[SIGMA_ATTITUDE + 1] = LEVEL_SIGMA


@kernel
def _sigma(f, state):
    return np.float32(math.sqrt(element(f, state, state)))


@kernel
def _flags(f, i, floats):
    word = np.int64(0)
    for event in range(np.int32(fl.GNSS_LOST)):
        if fl.is_recent(i, event):
            word |= ONE << event
    if i[at.TIME] - i[at.FIX_TIME] > i[cfg.GNSS_LOST_NS]:
        word |= ONE << fl.GNSS_LOST
    north = floats[SIGMA_POSITION]
    east = floats[SIGMA_POSITION + 1]
    if not north * north + east * east < f[cfg.UNCERTAIN_SQUARE]:
        word |= ONE << fl.POSITION_UNCERTAIN
    if i[cfg.REFERENCE_ON] != 0:
        if fl.is_recent(i, fl.ATTITUDE_REJECTED):
            word |= ONE << fl.ATTITUDE_REJECTED
        if i[at.TIME] - i[ref.LAST_USED] > i[ref.LOST_NS]:
            word |= ONE << fl.ATTITUDE_LOST
    return word


@kernel("void(float32[::1], float32[::1])")
def covariance(f, out):
    """Upper triangle (45, row by row) of the covariance of [δr, δv, φ]; zeros before navigation begins."""
    place = 0
    for a in range(np.int32(at.DYNAMIC_STATES)):
        for b in range(np.int32(a), np.int32(at.DYNAMIC_STATES)):
            out[place] = element(f, a, b)
            place += 1


@kernel("void(float32[::1], float32[::1])")
def innovation(f, out):
    """Innovations and their sigmas (12) of the last GNSS epoch; time and mask stand in
    layout.INNOVATION_…."""
    for k in range(np.int32(6)):
        out[k] = f[at.LAST_INNOVATION + k]
        out[6 + k] = f[at.LAST_INNOVATION_SIGMA + k]


@kernel("void(float32[::1], float32[::1])")
def biases(f, out):
    """Biases, mounting angles and latency with their sigmas (18)."""
    for k in range(THREE):
        a = at.X_GYRO_BIAS + k
        b = at.X_GYRO_INSTABILITY + k
        out[k] = f[at.GYRO_BIAS + k] + f[at.GYRO_INSTABILITY + k]
        out[9 + k] = np.float32(math.sqrt(element(f, a, a) + TWO * element(f, a, b) + element(f, b, b)))
        out[3 + k] = f[at.ACCEL_BIAS + k]
        out[12 + k] = _sigma(f, at.X_ACCEL_BIAS + k)
        out[6 + k] = f[at.MOUNTING + k]
        out[15 + k] = _sigma(f, at.X_MOUNTING + k)
    out[8] += f[cfg.LATENCY_NOMINAL]
