"""Error conventions against another library and closed forms."""

import numpy as np
import pymap3d
import pytest
from scipy.spatial.transform import Rotation
from synthetic_drive import Errors, motion, solution, times

from host.score.errors import attitude_error, position_error_ned, quaternions, solution_errors, wrapped


def rotation(yaw, pitch, roll):
    return Rotation.from_euler("ZYX", np.stack((yaw, pitch, roll), axis=1))


def test_position_error_agrees_with_pymap3d():
    truth = motion(times(0, 60, 1))
    estimate = solution(truth.t, Errors(position=(3.0, -4.0, 1.5)))
    expected = pymap3d.geodetic2ned(
        estimate.latitude, estimate.longitude, estimate.height,
        truth.latitude, truth.longitude, truth.height, deg=False,
    )  # fmt: skip
    np.testing.assert_allclose(position_error_ned(estimate, truth), np.stack(expected, axis=1), atol=1e-4)


def test_position_error_across_the_date_line_is_small():
    truth = motion(np.array([0.0]))
    west = type(truth)(
        **{name: getattr(truth, name) for name in truth.__slots__} | {"longitude": np.array([-np.pi + 1e-7])}
    )
    east = type(truth)(
        **{name: getattr(truth, name) for name in truth.__slots__} | {"longitude": np.array([np.pi - 1e-7])}
    )
    assert abs(position_error_ned(west, east)[0, 1]) == pytest.approx(
        2e-7 * 6388137 * np.cos(truth.latitude[0]), rel=1e-2
    )


def test_quaternions_and_attitude_error_agree_with_scipy():
    rng = np.random.default_rng(5)
    yaw, roll = rng.uniform(-np.pi, np.pi, (2, 200))
    pitch = rng.uniform(-1.5, 1.5, 200)
    true = rotation(yaw, pitch, roll)
    psi = rng.normal(0, 0.5, (200, 3))
    estimated = Rotation.from_rotvec(psi) * true
    q_true = quaternions(yaw, pitch, roll)
    q_estimated = estimated.as_quat(scalar_first=True)
    np.testing.assert_allclose(
        np.abs(np.sum(q_true * true.as_quat(scalar_first=True), axis=1)), 1, atol=1e-12
    )
    np.testing.assert_allclose(attitude_error(q_estimated, q_true), psi, atol=1e-10)


def test_half_a_turn_of_yaw_error_is_told_as_such():
    t = np.array([10.0])
    errors = solution_errors(solution(t, Errors(yaw_pitch_roll=(np.pi, 0, 0))), motion(t))
    assert abs(errors[0, 11]) == pytest.approx(np.pi, abs=1e-6)
    assert np.linalg.norm(errors[0, 6:9]) == pytest.approx(np.pi, abs=1e-6)


def test_constant_errors_come_out_in_their_columns():
    t = times(0, 20, 10)
    errors = solution_errors(
        solution(t, Errors((1.0, 2.0, -3.0), (0.1, -0.2, 0.3), (0.01, -0.02, 0.03))), motion(t)
    )
    expected = (1.0, 2.0, -3.0, 0.1, -0.2, 0.3)
    np.testing.assert_allclose(errors[:, :6], np.tile(expected, (len(t), 1)), atol=1e-4)
    np.testing.assert_allclose(errors[:, 9:], np.tile((0.03, -0.02, 0.01), (len(t), 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("angle", "expected"), [(3.5, 3.5 - 2 * np.pi), (-3.5, 2 * np.pi - 3.5), (np.pi, np.pi), (0.2, 0.2)]
)
def test_wrapped_angles(angle, expected):
    assert wrapped(np.array([angle]))[0] == pytest.approx(expected)
