"""What navigation gives out, against what is in its state, and the meaning of its errors."""

import math

import numpy as np
import pytest
from nav_run import dcm, full_matrix, rotation_error
from scipy.spatial.transform import Rotation

from firmware.nav import layout as at
from firmware.nav import solution as out
from firmware.nav.config import NavConfig, new_state

N = at.STATES


@pytest.fixture
def state():
    """A navigating state with a random covariance."""
    rng = np.random.default_rng(4)
    f, i = new_state(NavConfig())
    i[at.MODE], i[at.TIME], i[at.GOOD_SAMPLE_TIME] = 3, 10**9, 10**9
    i[at.LATITUDE], i[at.LONGITUDE] = round(math.radians(-33.1) * 2**40), round(math.radians(151.2) * 2**40)
    f[at.HEIGHT], f[at.VELOCITY : at.VELOCITY + 3] = 71.5, (3.0, -4.0, 0.5)
    q = Rotation.from_euler("ZYX", (5.9, 0.2, -0.4)).as_quat(scalar_first=True)
    f[at.QUATERNION : at.QUATERNION + 4] = q
    f[at.U : at.U + N * N] = np.triu(rng.normal(size=(N, N)), 1).T.ravel()
    f[at.D : at.D + N] = rng.uniform(0.1, 2.0, N)
    f[at.GYRO_BIAS : at.GYRO_BIAS + at.PARAMETERS] = rng.normal(size=at.PARAMETERS)
    return f, i


def dense(f):
    """P in float64."""
    U = np.eye(N) + np.triu(f[at.U : at.U + N * N].astype(float).reshape(N, N).T, 1)
    return U @ np.diag(f[at.D : at.D + N].astype(float)) @ U.T


def test_solution_record(state) -> None:
    f, i = state
    floats, integers = np.zeros(out.SOLUTION_FLOATS, np.float32), np.zeros(out.SOLUTION_INTEGERS, np.int64)
    out.solution(f, i, floats, integers)
    assert integers[out.TIME_NS] == 10**9
    assert integers[out.LAT_NANODEG] * 1e-9 == pytest.approx(-33.1, abs=2e-9)
    assert integers[out.LON_NANODEG] * 1e-9 == pytest.approx(151.2, abs=2e-9)
    assert floats[out.HEIGHT] == np.float32(71.5)
    np.testing.assert_array_equal(floats[out.VELOCITY : out.VELOCITY + 3], (3.0, -4.0, 0.5))
    np.testing.assert_allclose(floats[out.YAW : out.ROLL + 1], (5.9, 0.2, -0.4), atol=1e-6)
    np.testing.assert_allclose(floats[out.SIGMA_POSITION :], np.sqrt(np.diag(dense(f)))[:9], rtol=1e-5)


def test_covariance_and_biases(state) -> None:
    f, _ = state
    triangle, values = np.zeros(out.COVARIANCE_FLOATS, np.float32), np.zeros(out.BIAS_FLOATS, np.float32)
    out.covariance(f, triangle)
    P = dense(f)
    np.testing.assert_allclose(full_matrix(triangle), P[:9, :9], rtol=1e-4, atol=1e-4)
    out.biases(f, values)
    wander = f[at.GYRO_INSTABILITY : at.GYRO_INSTABILITY + 3]
    np.testing.assert_allclose(values[:3], f[at.GYRO_BIAS : at.GYRO_BIAS + 3] + wander, rtol=1e-6)
    a, b = at.X_GYRO_BIAS, at.X_GYRO_INSTABILITY
    total = [P[a + k, a + k] + 2 * P[a + k, b + k] + P[b + k, b + k] for k in range(3)]
    np.testing.assert_allclose(values[9:12], np.sqrt(total), rtol=1e-4)
    np.testing.assert_array_equal(values[3:6], f[at.ACCEL_BIAS : at.ACCEL_BIAS + 3])
    assert values[8] == pytest.approx(f[at.LATENCY] + 0.08)


def test_meaning_of_the_attitude_error() -> None:
    """C_true = (I + [φ×]) C_told: yaw too small by 0.01 is φ_D = +0.01."""
    told = np.array((1.0, 0.05, -0.1))
    np.testing.assert_allclose(rotation_error(told, np.add(told, (0.01, 0, 0))), (0, 0, 0.01), atol=1e-4)
    phi = np.array((0.002, -0.003, 0.004))
    true = Rotation.from_rotvec(phi) * Rotation.from_euler("ZYX", told)
    np.testing.assert_allclose(rotation_error(told, true.as_euler("ZYX")), phi, atol=1e-6)
    np.testing.assert_allclose(dcm(*told), Rotation.from_euler("ZYX", told).as_matrix(), atol=1e-12)
