"""Each error of an inertial sensor does to its output what its number says."""

import math

import allantools
import numpy as np
import pytest
from standing import SECOND, sampled, world

from host.sim.errors.drawn import draw_specimen
from host.sim.errors.presets import load_preset

DPS = math.pi / 180.0
MG = 9.80665e-3


def test_a_perfect_sensor_feels_gravity_and_the_earths_turn_in_its_own_axes():
    c_b_s = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    level = sampled(world(initial={"yaw_deg": 90.0, "pitch_deg": 10.0}).imu("a"), 10, 1)
    turned = sampled(world(initial={"yaw_deg": 90.0, "pitch_deg": 10.0}).imu("a", c_b_s), 10, 1)
    np.testing.assert_allclose(turned[:, :3], level[:, :3] @ c_b_s, rtol=1e-14)
    np.testing.assert_allclose(turned[:, 3:6], level[:, 3:6] @ c_b_s, rtol=1e-14)
    assert np.linalg.norm(level[0, :3]) == pytest.approx(9.7934, abs=2e-3)
    assert np.linalg.norm(level[0, 3:6]) == pytest.approx(7.292115e-5, rel=1e-9)
    assert level[0, 0] > 1.6  # nose up: forward axis feels g sin 10°


def test_fixed_bias_and_scale():
    imu = {
        "preset": "perfect",
        "gyro": {"bias_dps": [0.3, -0.2, 0.1]},
        "accelerometer": {"bias_mg": 10.0, "scale_percent": [1.0, -2.0, 0.5]},
    }
    plain, wrong = sampled(world().imu("a"), 10, 1), sampled(world(imu=imu).imu("a"), 10, 1)
    np.testing.assert_allclose(
        wrong[:, 3:6] - plain[:, 3:6], np.tile([0.3 * DPS, -0.2 * DPS, 0.1 * DPS], (10, 1))
    )
    expected = plain[:, :3] * [1.01, 0.98, 1.005] + 10 * MG
    np.testing.assert_allclose(wrong[:, :3], expected, rtol=1e-12)


def test_misalignment_and_g_sensitivity_couple_axes_linearly():
    imu = {
        "preset": "perfect",
        "gyro": {"g_sensitivity_dps_per_g": 0.1},
        "accelerometer": {"misalignment_deg": 0.2},
    }
    up = sampled(world(imu=imu).imu("a"), 10, 1)[0]
    plain = sampled(world().imu("a"), 10, 1)[0]
    cross, drift = (up - plain)[:3] / plain[2], (up - plain)[3:6] / (plain[2] / 9.80665) / DPS
    assert 1e-4 < np.abs(cross[:2]).max() < 4 * 0.2 * DPS
    assert cross[2] == pytest.approx(0.0, abs=1e-15)  # coupling has no diagonal
    assert 0.01 < np.abs(drift).max() < 0.4


def test_turn_on_draws_have_the_sigma_of_the_preset():
    specimens = [draw_specimen(load_preset("bmi160"), seed, "imu") for seed in range(120)]
    bias_g = np.array([s.gyro.bias for s in specimens]).ravel() / DPS
    bias_a = np.array([s.accelerometer.bias for s in specimens]).ravel() / MG
    scale = np.array([s.gyro.scale for s in specimens]).ravel()
    cross = np.array([s.gyro.cross[~np.eye(3, dtype=bool)] for s in specimens]).ravel() / DPS
    for draws, sigma in ((bias_g, 0.5), (bias_a, 40.0), (scale, 0.005), (cross, 0.2)):
        spread = 4.0 / math.sqrt(2 * draws.size)
        assert np.sqrt(np.mean(draws**2)) == pytest.approx(sigma, rel=spread)
        assert abs(draws.mean()) < 4.0 * sigma / math.sqrt(draws.size)
    assert abs(np.corrcoef(bias_g, bias_a)[0, 1]) < 0.22


@pytest.mark.parametrize(
    ("bandwidth_hz", "density_factor"), [(50.0, 1.0), (20.0, 1.0), (150.0, math.sqrt(3.0))]
)
def test_white_noise_keeps_its_density_whatever_the_filter(bandwidth_hz, density_factor):
    imu = {
        "preset": "perfect",
        "gyro": {"noise_dps_per_rthz": 0.007},
        "accelerometer": {"noise_ug_per_rthz": 180.0},
    }
    data = sampled(world(imu=imu).imu("a"), 100, 600, bandwidth_hz)
    for column, density in ((0, 180e-3 * MG), (4, 0.007 * DPS)):
        values = data[:, column] - data[:, column].mean()
        assert values.std() == pytest.approx(density * math.sqrt(bandwidth_hz), rel=0.02)
        # a single-sided density n has the Allan deviation n / √(2τ)
        taus, deviation, *_ = allantools.oadev(values, rate=100.0, data_type="freq", taus=[0.5, 1.0, 2.0])
        coefficient = deviation * np.sqrt(2.0 * taus)
        assert coefficient.mean() == pytest.approx(density * density_factor, rel=0.05)


def test_channels_are_independent_of_one_another():
    quiet = {"preset": "bmi160", "gyro": {"noise_dps_per_rthz": 0.0}}
    loud = {"preset": "bmi160"}
    first, second = world(imu=quiet), world(imu=loud)
    alone = sampled(first.imu("a"), 100, 5)
    second.imu("b")
    beside = sampled(second.imu("a"), 100, 5)
    np.testing.assert_array_equal(alone[:, :3], beside[:, :3])
    assert not np.array_equal(alone[:, 3:6], beside[:, 3:6])
    assert not np.array_equal(sampled(world(imu=loud).imu("b"), 100, 5)[:, :3], beside[:, :3])
    assert not np.array_equal(sampled(world(2, imu=loud).imu("a"), 100, 5)[:, :3], beside[:, :3])


def test_blocks_may_be_cut_anywhere():
    times = 34 * SECOND + np.arange(300) * 9_999_991  # across the border of two chunks of nodes
    whole = world(imu={"preset": "bmi160"}).imu("a").sample(times, 40.0)
    sensor = world(imu={"preset": "bmi160"}).imu("a")
    parts = [sensor.sample(part, 40.0) for part in np.split(times, [1, 36, 37, 200])]
    np.testing.assert_array_equal(np.vstack(parts), whole)


def test_a_reconfigured_chip_may_go_back_in_time():
    sensor = world(imu={"preset": "bmi160"}).imu("a")
    sampled(sensor, 100, 1.0, start_s=35.0)
    again = sampled(sensor, 400, 0.5, start_s=35.2)
    assert np.isfinite(again).all()
    assert np.abs(again[:, 2] + 9.79).max() < 2.0


def test_bias_follows_temperature():
    imu = {
        "preset": "perfect",
        "gyro": {"bias_temperature_dps_per_k": 0.05},
        "temperature": {"start_c": 20.0, "rise_k": 10.0, "rise_time_s": 300.0},
    }
    w = world(imu=imu)
    sensor = w.imu("a")
    early, late = sampled(sensor, 1, 1)[0], sampled(sensor, 1, 1, start_s=600.0)[0]
    rise = 10.0 * (1.0 - math.exp(-2.0))
    assert early[6] == pytest.approx(20.0)
    assert late[6] == pytest.approx(20.0 + rise, abs=1e-4)
    drift = (late - early)[3:6] / rise / DPS
    assert 0.005 < np.abs(drift).max() < 0.2
    truth = w.truth(np.array([0, 600 * SECOND]))
    np.testing.assert_allclose((truth.bias_g[1] - truth.bias_g[0]) / rise / DPS, drift, rtol=1e-4)


def test_truth_tells_the_bias_that_the_sensor_has():
    imu = {"preset": "bmi160", "gyro": {"scale_error_percent": 0.0, "misalignment_deg": 0.0}}
    w, ideal = world(imu=imu), world()
    measured = sampled(w.imu("a"), 50, 400)[:, 3:6].mean(axis=0)
    true_rate = sampled(ideal.imu("a"), 50, 1)[0, 3:6]
    truth = w.truth(np.arange(0, 400) * SECOND)
    np.testing.assert_allclose(
        measured - true_rate, truth.bias_g.mean(axis=0), atol=4 * 0.0053 * DPS / math.sqrt(400)
    )


def test_without_a_sensor_the_bias_is_not_known():
    assert np.isnan(world().truth(np.array([0])).bias_g).all()
