"""Integrating what the simulator says perfect sensors feel leads back to its truth."""

import ecef_mechanization as oracle
import numpy as np
import pytest
from drives import PERFECT, SCENARIOS, attitude_difference, earth_state

from host.sim.scenario.load import load_scenario
from host.sim.simulated import SimulatedVehicle

SECOND = 1_000_000_000


def closed_loop(name, lever, rate_hz, seconds):
    """Errors of the oracle after `seconds`: position (NED, m), velocity (m/s), attitude (rad)."""
    vehicle = SimulatedVehicle(load_scenario(SCENARIOS / f"{name}.toml", PERFECT), seed=3)
    imu = vehicle.imu("imu", np.eye(3), lever)
    times = np.arange(2 * rate_hz * seconds + 1) * (SECOND // (2 * rate_hz))
    felt = imu.sample(times, 50.0)
    rows = vehicle.motion.rows(times[[0, -1]])
    start, _ = earth_state(rows[0], lever)
    end, c_en = earth_state(rows[1], lever)
    state = oracle.integrate(start, felt[:, :3].copy(), felt[:, 3:6].copy(), 1.0 / rate_hz)
    return c_en.T @ (state[:3] - end[:3]), state[3:6] - end[3:6], attitude_difference(state[6:], end[6:])


@pytest.mark.soak
def test_twenty_minutes_in_town_at_200_hz():
    position, velocity, attitude = closed_loop("town-open", np.zeros(3), 200, 1200)
    assert np.abs(position).max() < 1e-5
    assert np.abs(velocity).max() < 1e-6
    assert np.degrees(attitude) < 1e-7


def test_a_sensor_away_from_the_origin_at_400_hz():
    position, velocity, _ = closed_loop("town-open", np.array([1.2, -0.4, 0.6]), 400, 600)
    assert np.abs(position).max() < 1e-5
    assert np.abs(velocity).max() < 1e-6


def test_vibration_and_coning_converge_with_the_order_of_the_integrator():
    lever = np.array([0.5, 0.3, -0.2])
    coarse = closed_loop("rough", lever, 200, 150)
    fine = closed_loop("rough", lever, 400, 150)
    assert np.linalg.norm(fine[0]) < 1e-3
    assert 11.0 < np.linalg.norm(coarse[0]) / np.linalg.norm(fine[0]) < 21.0
    assert 11.0 < coarse[2] / fine[2] < 21.0
