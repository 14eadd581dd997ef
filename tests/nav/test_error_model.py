"""The covariance's model of error growth against the mechanization itself, by finite differences.

Each of the 36 states is disturbed a little, the strapdown runs for an interval from the disturbed and from
the undisturbed state (float64), and the difference is a column of the true transition matrix. The prediction
of the filter gives the same column: with one variance alone at the beginning, P = Φ e eᵀ Φᵀ.
"""

import math

import numpy as np
import pytest
from float64_doors import float64_doors
from nav_run import full_matrix
from scipy.spatial.transform import Rotation

from firmware.nav import layout as at
from firmware.nav.config import NavConfig, new_state

DT, STEPS = 0.01, 300
STEP_NS = 10_000_000
UNITS = 2.0**40
QUIET = {
    "angle_random_walk": 1e-9, "velocity_random_walk": 1e-9, "position_walk": 0.0, "manoeuvre_noise": 0.0,
    "gyro_bias_walk": 0.0, "accel_bias_walk": 0.0, "constraint": False,
    "standstill": False,
}  # fmt: skip
"""No noise: the transition alone."""
RATE, FORCE = np.array([0.05, -0.08, 0.6]), np.array([1.2, 3.0, -9.5])
BIAS = np.array([0.01, -0.02, 0.005])


LAST_SAMPLE = {
    0: (at.OMEGA_B, 1.0), 1: (at.FORCE_B, 1.0), 4: (at.OMEGA_B, RATE[2]), 5: (at.FORCE_B, FORCE[0]),
    6: (at.FORCE_B, FORCE[1]), 7: (at.OMEGA_B, 0.0), 8: (at.OMEGA_B, 1.0),
}  # fmt: skip
"""Where a parameter, by its number of three, entered the sample before, the first end of the trapezoid."""


def truth_minus(value):
    """How the estimate moves when its error state (truth minus estimate) grows by `value`."""
    return -value


def turned(f, phi):
    """Attitude of an estimate whose error is φ: C_est = (I − [φ×]) C_true."""
    q = Rotation.from_quat(f[at.QUATERNION : at.QUATERNION + 4], scalar_first=True)
    q = Rotation.from_rotvec(-np.asarray(phi)) * q
    f[at.QUATERNION : at.QUATERNION + 4] = q.as_quat(scalar_first=True)
    f[at.C_N_B : at.C_N_B + 9] = q.as_matrix().ravel()


def begin(config):
    """Navigating at 14 m/s in a turn."""
    f, i = new_state(config, np.float64)
    f[at.BIAS_TEMPERATURE] = 0.0
    i[at.MODE], i[at.HAVE_SAMPLE] = 3, 1
    i[at.TIME] = i[at.GOOD_SAMPLE_TIME] = i[at.CHECK_DUE] = i[at.CONSTRAINT_DUE] = 0
    i[at.LATITUDE], i[at.LONGITUDE] = round(math.radians(48.0) * UNITS), round(math.radians(11.0) * UNITS)
    f[at.HEIGHT], f[at.VELOCITY : at.VELOCITY + 3] = 300.0, (9.0, -11.0, 0.7)
    f[at.QUATERNION : at.QUATERNION + 4] = Rotation.from_euler("ZYX", (2.0, 0.1, -0.2)).as_quat(
        scalar_first=True
    )
    turned(f, np.zeros(3))
    f[at.GYRO_BIAS : at.GYRO_BIAS + 3] = BIAS
    f[at.OMEGA_B : at.OMEGA_B + 3] = RATE
    f[at.FORCE_B : at.FORCE_B + 3] = FORCE
    refresh = np.array([7.292115e-5 * math.cos(math.radians(48)), -7.292115e-5 * math.sin(math.radians(48))])
    f[at.EARTH_RATE_N : at.EARTH_RATE_N + 2] = refresh
    f[at.PER_MERIDIAN_RADIUS] = 1 / 6.37e6
    f[at.PER_NORMAL_RADIUS] = 1 / 6.39e6
    f[at.PER_COS_LATITUDE], f[at.TAN_LATITUDE], f[at.GRAVITY] = (
        1 / math.cos(math.radians(48)),
        math.tan(math.radians(48)),
        9.8,
    )
    f[at.SINCE_VELOCITY : at.SINCE_VELOCITY + 3] = f[at.VELOCITY : at.VELOCITY + 3]
    f[at.SINCE_C_N_B : at.SINCE_C_N_B + 9] = f[at.C_N_B : at.C_N_B + 9]
    return f, i


def disturb(f, i, state, size):
    """Move the estimate so that its error in `state` becomes `size`."""
    if state < at.X_VELOCITY:
        metres = truth_minus(size)
        if state == 0:
            i[at.LATITUDE] += round(metres / 6.37e6 * UNITS)
        elif state == 1:
            i[at.LONGITUDE] += round(metres / 6.39e6 / math.cos(math.radians(48)) * UNITS)
        else:
            f[at.HEIGHT] -= metres
    elif state < at.X_ATTITUDE:
        f[at.VELOCITY + state - at.X_VELOCITY] += truth_minus(size)
    elif state < at.X_GYRO_BIAS:
        turned(f, size * np.eye(3)[state - at.X_ATTITUDE])
    else:
        f[at.GYRO_BIAS + state - at.X_GYRO_BIAS] += truth_minus(size)
        place, per_unit = LAST_SAMPLE[(state - at.X_GYRO_BIAS) // 3]
        f[place + state % 3] += size * per_unit


def difference(f, i, g, j):
    """Error of estimate (g, j) against (f, i): position, velocity, attitude."""
    north = (i[at.LATITUDE] - j[at.LATITUDE]) / UNITS * 6.37e6
    east = (i[at.LONGITUDE] - j[at.LONGITUDE]) / UNITS * 6.39e6 * math.cos(math.radians(48))
    down = g[at.HEIGHT] + g[at.HEIGHT_REST] - f[at.HEIGHT] - f[at.HEIGHT_REST]
    velocity = f[at.VELOCITY : at.VELOCITY + 3] - g[at.VELOCITY : at.VELOCITY + 3]
    true, told = (a[at.C_N_B : at.C_N_B + 9].reshape(3, 3) for a in (f, g))
    phi = Rotation.from_matrix(true @ told.T).as_rotvec()
    return np.concatenate(((north, east, down), velocity, phi))


def advance(step, f, i):
    """Three seconds of a turn, in which the sensor warms by 1 K/s."""
    for k in range(1, STEPS + 1):
        f[at.TEMPERATURE] = 1.0 * k * DT
        w, a = RATE * (1 + 0.5 * math.sin(0.03 * k)), FORCE * (1 + 0.1 * math.sin(0.05 * k))
        step(f, i, k * STEP_NS, DT, *(w + BIAS), *a)


def size_of(state):
    """A disturbance well above rounding and well within linearity."""
    if state < at.X_VELOCITY:
        return 10.0
    if state < at.X_ATTITUDE:
        return 0.1
    accelerometer = (
        at.X_ACCEL_BIAS <= state < at.X_GNSS_ERROR or at.X_FORCE_RESPONSE <= state < at.X_GYRO_PER_KELVIN
    )
    return 0.01 if accelerometer else 0.001


@pytest.fixture(scope="module")
def doors():
    """The float64 kernels."""
    return float64_doors()


@pytest.mark.parametrize(
    "state", [s for s in range(at.STATES) if not at.X_GNSS_ERROR <= s < at.X_YAW_RESPONSE]
)
def test_prediction_matches_the_mechanization(doors, state):
    """Column by column, over three seconds of a turn; GNSS error, mounting and latency drive nothing."""
    imu, _, solution, _ = doors
    config = NavConfig(**QUIET, covariance_period=0.1, check_period=100.0, gyro_instability_time=1e4)
    f, i = begin(config)
    g, j = f.copy(), i.copy()
    disturb(g, j, state, size_of(state))
    f[at.D + state] = 1.0
    advance(imu.imu_step, f, i)
    advance(imu.imu_step, g, j)
    column = difference(f, i, g, j) / size_of(state)
    triangle = np.zeros(45)
    solution.covariance(f, triangle)
    P = full_matrix(triangle)
    largest = int(np.argmax(np.abs(column)))
    assert abs(column[largest]) > 0.5
    predicted = P[:, largest] / math.sqrt(P[largest, largest]) * np.sign(column[largest])
    for group in (slice(0, 3), slice(3, 6), slice(6, 9)):
        allowed = 0.03 * np.linalg.norm(column[group]) + 0.002 * abs(column[largest])
        assert np.linalg.norm(predicted[group] - column[group]) < allowed, (predicted, column)
