"""GPS in the gyro-free filters: position and velocity, compared where the epoch is valid.

While heading is not known its error turns the Earth rate to the wrong side, and tilt follows:

    φ_E' = ω_N φ_D,  φ_N' = −ω_E φ_D,   ω_in = (Ω cos φ + v_E / R_N, −v_N / R_M, …)

The core leaves this out: a heading known to a degree makes 0.3°/h of it. Without compass it is not small and
is done here, a second at a time (rows 6 and 7 of U take from row 8, U stays triangular). The error of heading
also turns tilt and accelerometer bias, δψ × b, which the model takes for a turn that would tell one from the
other; both become as uncertain as that product may be.

Heading itself shows in a horizontal force only. Without one, as on a straight road, what the linear model
takes for information on a heading that may be wrong by tens of degrees is its own error; then heading and the
bias of its rate are considered, not estimated: their uncertainty counts in every gain, and neither is
corrected (the filter of Schmidt). With the optimal gain K of all states, S the variance of the innovation, c
the two:

    P_Schmidt = P_optimal + K_c S K_cᵀ

The rows are those of the navigation core less the receiver's correlated error and its latency, which these
filters do not have. Position (3) and velocity (3, or 2 from speed and course) pass a χ² gate each.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.covariance import (
    absorb_projected,
    add_along_gain,
    add_variance,
    element,
    project,
    projected_product,
)
from firmware.nav.earth import refresh_earth
from firmware.nav.feedback import clear_correction, feed_back
from firmware.nav.gnss_measurement import position_rows, velocity_rows
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.states import ALL, COMPASS_ERROR, X_COMPASS_ERROR
from firmware.nav.heading import has_course
from firmware.nav.history import correct_past, look_up
from firmware.nav.measurement import absorb_group, clear_rows, weigh_group
from firmware.nav.prediction import predict
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
LONGEST = np.float32(100.0)
"""s; a longer pause is not worth a linear model."""
THREE = np.int32(3)
VELOCITY_ROW = 3
YAW = np.int32(at.X_ATTITUDE + 2)
YAW_BIAS = np.int32(at.X_GYRO_BIAS + 2)
WIDE = np.float32(0.1 * 0.1)
"""rad², of heading."""
LEAST_FORCE_SQUARE = np.float32(0.3 * 0.3)
"""(m/s²)², horizontal."""


@kernel
def gps_update(f, i, g, e, since):
    """Correct `f`, `i` by an epoch with a position; whether all of it was believed. `since`: s since the
    epoch before."""
    time = e[gnss.VALID_NS]
    predict(f)
    _couple_heading(f, since)
    refresh_earth(f, i)
    if not look_up(f, i, time):
        return False
    correct_past(f, i, time)
    clear_correction(f)
    clear_rows(f)
    position_rows(f, i, e, time)
    for k in range(THREE):
        f[at.RESIDUAL + k] += f[COMPASS_ERROR + k]
        f[at.ROWS + k * at.STATES + X_COMPASS_ERROR + k] = ZERO
        f[at.VARIANCE + k] = g[gl.GPS_VARIANCE + (1 if k == 2 else 0)]
    count = 3 if e[gnss.FLAGS] & gnss.HAS_HEIGHT else 2
    passes = _passes(f, g, 0, count)
    moving = has_course(e)
    velocities = 3 if e[gnss.FLAGS] & gnss.HAS_VELOCITY else 2
    velocity_passes = True
    if moving:
        velocity_rows(f, i, e, time)
        for k in range(THREE):
            f[at.VARIANCE + VELOCITY_ROW + k] = g[gl.GPS_VARIANCE + 2]
        velocity_passes = _passes(f, g, VELOCITY_ROW, velocities)
    considered = _is_heading_out_of_reach(f)
    if passes:
        _absorb(f, 0, count, considered)
    if moving and velocity_passes:
        _absorb(f, VELOCITY_ROW, velocities, considered)
    feed_back(f, i)
    return passes and velocity_passes


@kernel
def _couple_heading(f, t):
    """What the error of heading has made of tilt, and of what is known of tilt and bias, over `t` s."""
    if not t <= LONGEST:
        return
    north = t * (f[at.EARTH_RATE_N] + f[at.VELOCITY + 1] * f[at.PER_NORMAL_RADIUS])
    east = -t * f[at.VELOCITY] * f[at.PER_MERIDIAN_RADIUS]
    yaw = at.X_ATTITUDE + 2
    grown = TWO * t * abs(element(f, yaw, at.X_GYRO_BIAS + 2))
    turned = grown * f[cfg.ACCEL_BIAS_VARIANCE]
    per_g = ONE / f[at.GRAVITY]
    for k in range(np.int32(2)):
        add_variance(f, at.X_ACCEL_BIAS + k, turned)
        add_variance(f, at.X_ATTITUDE + k, turned * per_g * per_g)
    for j in range(np.int32(yaw), np.int32(ALL)):
        column = at.U + j * at.STATES
        u = ONE if j == yaw else f[column + yaw]
        f[column + yaw - 2] -= east * u
        f[column + yaw - 1] += north * u


@kernel
def _is_heading_out_of_reach(f):
    """Heading too uncertain for the linear model, and no force to show it."""
    if element(f, YAW, YAW) < WIDE:
        return False
    north = f[at.AGO_ACCELERATION]
    east = f[at.AGO_ACCELERATION + 1]
    return north * north + east * east < LEAST_FORCE_SQUARE


@kernel
def _absorb(f, first, count, considered):
    if not considered:
        absorb_group(f, first, count)
        return
    for row in range(np.int32(first), np.int32(first + count)):
        project(f, row)
        s = projected_product(f, row, row) + f[at.VARIANCE + row]
        absorb_projected(f, row)
        f[at.CORRECTION + YAW] = ZERO
        f[at.CORRECTION + YAW_BIAS] = ZERO
        for j in range(YAW_BIAS):
            if j != YAW:
                f[at.GAIN + j] = ZERO
        add_along_gain(f, YAW_BIAS, ONE / s)


@kernel
def _passes(f, g, first, count):
    """Whether rows of one kind agree with what is known; asked of all before any is absorbed."""
    return weigh_group(f, first, count) <= (g[gl.GATE_3] if count == 3 else g[gl.GATE_2])
