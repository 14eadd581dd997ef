"""Constants put on errors are found again."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from synthetic_drive import motion, times

from host.score.errors import quaternions
from host.score.recording_fit import RecordingFit, fit_mounting, fit_shift_and_offset


def drive():
    """Truth with speeding up and braking, so that a time shift differs from a forward offset."""
    truth = motion(times(0, 60, 5))
    velocity = truth.velocity_ned * (1 + 0.6 * np.sin(truth.t / 4))[:, None]
    q_nb = quaternions(truth.yaw, truth.pitch, truth.roll)
    return velocity, q_nb


def test_time_shift_and_offset_are_found_and_removed():
    velocity, q_nb = drive()
    C_n_b = Rotation.from_quat(q_nb, scalar_first=True).as_matrix()
    errors = velocity * 0.08 + C_n_b @ np.array([1.2, -0.3, 0.5])
    found = fit_shift_and_offset(errors, velocity, q_nb)
    assert found["time_shift_s"] == pytest.approx(0.08, abs=1e-9)
    assert found["offset_frd_m"] == pytest.approx([1.2, -0.3, 0.5], abs=1e-8)
    assert found["after_position_horizontal_rms_m"] == pytest.approx(0.0, abs=1e-8)
    expected = np.sqrt(np.mean(errors[:, 0] ** 2 + errors[:, 1] ** 2))
    assert found["before_position_horizontal_rms_m"] == pytest.approx(expected)
    assert found["condition"] < 100


def test_noise_is_left_and_the_fit_is_never_worse():
    velocity, q_nb = drive()
    noise = np.random.default_rng(4).normal(0, 0.4, (len(velocity), 3))
    found = fit_shift_and_offset(noise, velocity, q_nb)
    assert abs(found["time_shift_s"]) < 0.02
    assert found["after_position_horizontal_rms_m"] == pytest.approx(0.4 * np.sqrt(2), rel=0.08)


def test_mounting_is_found_and_told_in_degrees():
    _, q_nb = drive()
    true = Rotation.from_quat(q_nb, scalar_first=True)
    offset = Rotation.from_euler("ZYX", [1.0, -4.0, 2.0], degrees=True)
    psi = (true * offset * true.inv()).as_rotvec()
    found = fit_mounting(psi, q_nb)
    assert found["mounting_deg"] == pytest.approx({"roll": 2.0, "pitch": -4.0, "yaw": 1.0}, abs=1e-9)
    assert found["after_yaw_rms_deg"] == pytest.approx(0.0, abs=1e-9)


def test_too_few_epochs_give_no_constants():
    fit = RecordingFit()
    fit.add(np.zeros((3, 12)), np.zeros((3, 6)), np.ones((3, 3)), np.tile([1.0, 0, 0, 0], (3, 1)))
    assert fit.result() == {"epochs": 3}
