"""Prediction of the covariance over the time since the last one, in one go: five to ten times a second.

Error model (n frame, truth minus estimate; C_n_b_true = (I + [φ×]) C_n_b):

    δr' = δv
    δv' = −f_n × φ − C_n_b (δb_a + f_x δr_x + f_y δr_y)
    φ'  = −C_n_b (δb_g + ω_z δs)

(s, r: responses, layout) over the interval T, with ∫f_n dt = Δv − g T from the velocities at its ends (exact,
whatever the motion between), the mean C_n_b of its ends, ∫ω_z dt, ∫f_x dt and ∫f_y dt summed, and the
trapezoid for what each row feeds to the next.

At rest tilt and accelerometer bias cannot be told apart: an error φ with f_n × φ = −C_n_b δb_a is not
observable. Corrections would turn C_n_b, and with every turn the filter would take a little of that error for
observed; so C_n_b of the error model stays the same for as long as the vehicle rests (Huang, Mourikis and
Roumeliotis, Observability-based rules for designing consistent EKF SLAM estimators, IJRR 29 (2010)).

With `earth_rate_errors` also φ' = −ω_in × φ, once a second (attitude_reset turns the covariance). It is
0.05 °/h for φ = 0.2°: nothing to a MEMS gyro, but how a gyro of 0.1 °/h tells yaw from its own bias.

Left out, because far below what the sensors do: Coriolis and transport terms in δv and δr (0.7 µg for an
error of 0.05 m/s), gravity gradient (0.5 µg for 1.5 m), and the error of the transport rate (0.002 °/h for
0.05 m/s). Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed.,
section 14.2.4.

Parameters: biases walk, the gyro bias also follows the temperature of the chip (temperature); the correlated
GNSS error and the instability of the gyros are first-order Gauss-Markov processes; responses and temperature
coefficients are constant. This is done once a second: the coefficients add their rows of U to those of the
bias (U stays triangular), the noise is a sum of rank-one terms.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.attitude_reset import turn_attitude_error
from firmware.nav.covariance import add_variance, scale_state
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
PARAMETER_PERIOD = np.float32(0.95)
INSTABILITY = at.X_GYRO_INSTABILITY - at.X_GYRO_BIAS
RESPONSE = at.X_YAW_RESPONSE - at.X_GYRO_BIAS
LEAST_DECAY = np.float32(0.1)
N = np.int32(at.STATES)
THREE = np.int32(3)
THREE_F = np.float32(3.0)


@kernel
def begin_interval(f):
    """The next prediction starts from the present state."""
    f[at.SINCE_TIME] = ZERO
    for k in range(THREE):
        f[at.SINCE_YAW_ANGLE + k] = ZERO
        f[at.SINCE_VELOCITY + k] = f[at.VELOCITY + k]
    if f[at.AT_REST] == ZERO:
        for k in range(np.int32(9)):
            f[at.SINCE_C_N_B + k] = f[at.C_N_B + k]
    f[at.LOST_TILT] = ZERO
    f[at.LOST_YAW] = ZERO
    f[at.LOST_VELOCITY] = ZERO
    f[at.LOST_POSITION] = ZERO


@kernel
def leave_rest(f):
    """The error model takes the present attitude again; accelerometer biases were counted in other axes."""
    cosine = ZERO
    for k in range(np.int32(9)):
        cosine += f[at.SINCE_C_N_B + k] * f[at.C_N_B + k]
    square = max(THREE_F - cosine, ZERO)
    for k in range(THREE):
        add_variance(f, at.X_ACCEL_BIAS + k, square * f[cfg.ACCEL_BIAS_VARIANCE])
    f[at.AT_REST] = ZERO
    for k in range(np.int32(9)):
        f[at.SINCE_C_N_B + k] = f[at.C_N_B + k]


@kernel
def predict(f):
    """Carry the covariance to the present; parameters too, when a second has passed."""
    t = f[at.SINCE_TIME]
    if not t <= ZERO:
        _map_dynamic_columns(f, t)
        _map_parameter_columns(f, t)
        _add_noise(f, t)
        f[at.PARAMETER_TIME] += t
        begin_interval(f)
    if not f[at.PARAMETER_TIME] <= PARAMETER_PERIOD:
        _carry_parameters(f)


@kernel
def predict_with_parameters(f):
    """The same, and parameters whenever they were carried last: for what is compared with another filter."""
    predict(f)
    if not f[at.PARAMETER_TIME] <= ZERO:
        _carry_parameters(f)


@kernel
def _carry_parameters(f):
    _walk_parameters(f, f[at.PARAMETER_TIME])
    if f[cfg.EARTH_ERRORS] != ZERO:
        _turn_with_earth(f, f[at.PARAMETER_TIME])
    f[at.PARAMETER_TIME] = ZERO


@kernel
def _turn_with_earth(f, t):
    """φ → φ − ω_in T × φ."""
    north = f[at.VELOCITY + 1] * f[at.PER_NORMAL_RADIUS]
    turn_attitude_error(
        f,
        t * (f[at.EARTH_RATE_N] + north),
        -t * f[at.VELOCITY] * f[at.PER_MERIDIAN_RADIUS],
        t * (f[at.EARTH_RATE_D] - north * f[at.TAN_LATITUDE]),
    )


@kernel
def _force_integral(f, t):
    """∫f_n dt: only gravity is taken off, the rest of the velocity equation is far below its noise."""
    return (
        f[at.VELOCITY] - f[at.SINCE_VELOCITY],
        f[at.VELOCITY + 1] - f[at.SINCE_VELOCITY + 1],
        f[at.VELOCITY + 2] - f[at.SINCE_VELOCITY + 2] - f[at.GRAVITY] * t,
    )


@kernel
def _map_dynamic_columns(f, t):
    """Columns of velocity and attitude: each is an error state of its own, moved over the interval."""
    sx, sy, sz = _force_integral(f, t)
    half_t = HALF * t
    for j in range(np.int32(at.X_VELOCITY), np.int32(at.DYNAMIC_STATES)):
        u = at.U + j * at.STATES
        px = _entry(f, j, at.X_ATTITUDE)
        py = _entry(f, j, at.X_ATTITUDE + 1)
        pz = _entry(f, j, at.X_ATTITUDE + 2)
        vx = _entry(f, j, at.X_VELOCITY)
        vy = _entry(f, j, at.X_VELOCITY + 1)
        vz = _entry(f, j, at.X_VELOCITY + 2)
        nx = vx - (sy * pz - sz * py)
        ny = vy - (sz * px - sx * pz)
        nz = vz - (sx * py - sy * px)
        f[u] += half_t * (vx + nx)
        f[u + 1] += half_t * (vy + ny)
        f[u + 2] += half_t * (vz + nz)
        if j >= at.X_ATTITUDE:
            f[u + at.X_VELOCITY] = nx
            f[u + at.X_VELOCITY + 1] = ny
            f[u + at.X_VELOCITY + 2] = nz


@kernel
def _map_parameter_columns(f, t):
    """The same for the columns of the parameters, which drive velocity and attitude."""
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = _mean_attitude(f)
    sx, sy, sz = _force_integral(f, t)
    half_t = HALF * t
    for j in range(np.int32(at.DYNAMIC_STATES), N):
        u = at.U + j * at.STATES
        gx = _rate_entries(f, j, at.X_GYRO_BIAS, t)
        gy = _rate_entries(f, j, at.X_GYRO_BIAS + 1, t)
        gz = _rate_entries(f, j, at.X_GYRO_BIAS + 2, t)
        dx = t * _entry(f, j, at.X_ACCEL_BIAS) + _force_entries(f, j, at.X_FORCE_RESPONSE)
        dy = t * _entry(f, j, at.X_ACCEL_BIAS + 1) + _force_entries(f, j, at.X_FORCE_RESPONSE + 1)
        dz = t * _entry(f, j, at.X_ACCEL_BIAS + 2) + _force_entries(f, j, at.X_FORCE_RESPONSE + 2)
        px = f[u + 6]
        py = f[u + 7]
        pz = f[u + 8]
        ax = px - (c00 * gx + c01 * gy + c02 * gz)
        ay = py - (c10 * gx + c11 * gy + c12 * gz)
        az = pz - (c20 * gx + c21 * gy + c22 * gz)
        f[u + 6] = ax
        f[u + 7] = ay
        f[u + 8] = az
        mx = HALF * (px + ax)
        my = HALF * (py + ay)
        mz = HALF * (pz + az)
        vx = f[u + 3]
        vy = f[u + 4]
        vz = f[u + 5]
        nx = vx - (sy * mz - sz * my) - (c00 * dx + c01 * dy + c02 * dz)
        ny = vy - (sz * mx - sx * mz) - (c10 * dx + c11 * dy + c12 * dz)
        nz = vz - (sx * my - sy * mx) - (c20 * dx + c21 * dy + c22 * dz)
        f[u + 3] = nx
        f[u + 4] = ny
        f[u + 5] = nz
        f[u] += half_t * (vx + nx)
        f[u + 1] += half_t * (vy + ny)
        f[u + 2] += half_t * (vz + nz)


@kernel
def _entry(f, column, row):
    """U[row, column], diagonal and lower triangle included."""
    if row < column:
        return f[at.U + column * at.STATES + row]
    return ONE if row == column else ZERO


@kernel
def _rate_entries(f, column, row, t):
    """T times the entries of bias and instability, ∫ω_z dt times that of the response, of one gyro."""
    constant = _entry(f, column, row) + _entry(f, column, row + INSTABILITY)
    return t * constant + f[at.SINCE_YAW_ANGLE] * _entry(f, column, row + RESPONSE)


@kernel
def _force_entries(f, column, row):
    """∫f_x dt and ∫f_y dt times the entries of their responses."""
    return f[at.SINCE_FORCE] * _entry(f, column, row) + f[at.SINCE_FORCE + 1] * _entry(f, column, row + 3)


@kernel
def _mean_attitude(f):
    a = at.SINCE_C_N_B
    b = a if f[at.AT_REST] != ZERO else at.C_N_B
    return (
        HALF * (f[a] + f[b]),
        HALF * (f[a + 1] + f[b + 1]),
        HALF * (f[a + 2] + f[b + 2]),
        HALF * (f[a + 3] + f[b + 3]),
        HALF * (f[a + 4] + f[b + 4]),
        HALF * (f[a + 5] + f[b + 5]),
        HALF * (f[a + 6] + f[b + 6]),
        HALF * (f[a + 7] + f[b + 7]),
        HALF * (f[a + 8] + f[b + 8]),
    )


@kernel
def _add_noise(f, t):
    """Position, velocity and attitude become less certain over the interval."""
    ax = f[at.VELOCITY] - f[at.SINCE_VELOCITY]
    ay = f[at.VELOCITY + 1] - f[at.SINCE_VELOCITY + 1]
    manoeuvre = (ax * ax + ay * ay) * f[cfg.MANOEUVRE_VARIANCE] / t
    velocity = f[cfg.VELOCITY_WALK_VARIANCE] * t + manoeuvre + f[at.LOST_VELOCITY]
    attitude = f[cfg.ANGLE_WALK_VARIANCE] * t
    position = f[cfg.POSITION_WALK_VARIANCE] * f[at.SCATTER_SHARE] * t + f[at.LOST_POSITION]
    for k in range(THREE):
        add_variance(f, at.X_POSITION + k, position)
        add_variance(f, at.X_VELOCITY + k, velocity)
        add_variance(f, at.X_ATTITUDE + k, attitude + (f[at.LOST_YAW] if k == 2 else f[at.LOST_TILT]))


@kernel
def _walk_parameters(f, t):
    """What the parameters do over t, and their process noise."""
    warmer = f[at.TEMPERATURE] - f[at.BIAS_TEMPERATURE]
    f[at.BIAS_TEMPERATURE] = f[at.TEMPERATURE]
    for k in range(THREE):
        f[at.GYRO_BIAS + k] += warmer * f[at.GYRO_PER_KELVIN + k]
        for j in range(np.int32(at.X_GYRO_PER_KELVIN), N):
            f[at.U + j * at.STATES + at.X_GYRO_BIAS + k] += warmer * _entry(f, j, at.X_GYRO_PER_KELVIN + k)
    for k in range(THREE):
        variance = f[cfg.POSITION_ERROR_VARIANCE_H] if k < 2 else f[cfg.POSITION_ERROR_VARIANCE_V]
        if f[cfg.POSITION_ERROR_WEIGHT] != ZERO:
            variance = ZERO
        factor = _decay(f, at.X_GNSS_ERROR + k, t * f[cfg.PER_POSITION_ERROR_TIME])
        add_variance(f, at.X_GNSS_ERROR + k, (ONE - factor * factor) * variance)
        factor = _decay(f, at.X_GYRO_INSTABILITY + k, t * f[cfg.PER_INSTABILITY_TIME])
        add_variance(f, at.X_GYRO_INSTABILITY + k, (ONE - factor * factor) * f[cfg.GYRO_INSTABILITY_VARIANCE])
        add_variance(f, at.X_GYRO_BIAS + k, t * f[cfg.GYRO_BIAS_WALK_VARIANCE])
        add_variance(f, at.X_ACCEL_BIAS + k, t * f[cfg.ACCEL_BIAS_WALK_VARIANCE])


@kernel
def _decay(f, state, share):
    """Exponential decay of a parameter over `share` of its time constant; the factor."""
    factor = max(ONE - share, LEAST_DECAY)
    scale_state(f, state, factor)
    f[at.GYRO_BIAS + state - at.X_GYRO_BIAS] *= factor
    return factor
