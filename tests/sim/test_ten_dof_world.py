"""What a sensor of rate, force, field and pressure feels, against scipy and tables of the atmosphere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from scipy.spatial.transform import Rotation

from host.sim.compass import dipole_field
from host.sim.scenario.load import scenario_from
from host.sim.ten_dof import standard_pressure
from host.sim.world import World

SECOND = 1_000_000_000
MOUNTING = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])


def world(yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0, seed: int = 1, **place: float) -> World:
    data: dict[str, Any] = {
        "place": {"latitude_deg": 47.0, "longitude_deg": 8.0, "height_m": 400.0, "geoid_separation_m": 0.0}
        | place,
        "duration_s": 20.0,
        "initial": {"yaw_deg": yaw, "pitch_deg": pitch, "roll_deg": roll},
        "segment": [{"kind": "rest", "duration_s": 20.0}],
    }
    return World(scenario_from(data, "standing", "test"), seed)


@settings(max_examples=15, deadline=None)
@given(
    some.floats(0, 359),
    some.floats(-80, 80),
    some.floats(-85, 85),
    some.floats(-70, 70),
    some.floats(-170, 170),
)
def test_field_at_any_place_and_attitude(
    yaw: float, pitch: float, roll: float, latitude: float, longitude: float
) -> None:
    place = {"latitude_deg": latitude, "longitude_deg": longitude}
    felt = world(yaw, pitch, roll, **place).ten_dof("U1", MOUNTING, preset="perfect")
    (values,) = felt.sample(np.array([5 * SECOND]), 330.0)
    c_nb = Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True).as_matrix()
    expected = (c_nb @ MOUNTING).T @ dipole_field(np.radians(latitude), np.radians(longitude), 400.0)
    assert values[7:10] == pytest.approx(expected, abs=1e-11)
    assert values[10] == pytest.approx(96_611.0, abs=2.0)


@pytest.mark.parametrize(
    ("height", "hpa"),
    [(0.0, 1013.25), (1000.0, 898.75), (3000.0, 701.09), (8000.0, 356.00), (-500.0, 1074.78)],
)
def test_pressure_of_the_standard_atmosphere(height: float, hpa: float) -> None:
    assert float(standard_pressure(np.array([height]))[0]) == pytest.approx(100.0 * hpa, rel=5e-4)


def test_same_seed_same_values() -> None:
    times = np.arange(1, 200) * 1_220_703
    first, second = (world().ten_dof("U1", preset="adis16407").sample(times, 330.0) for _ in range(2))
    assert (first == second).all()
    other = world(seed=2).ten_dof("U1", preset="adis16407").sample(times, 330.0)
    assert (other != first)[:, [0, 3, 7, 10]].all()
    assert first[:, 10].std() == pytest.approx(2.7, rel=0.2)


def test_inertial_columns_are_those_of_the_inertial_sensor() -> None:
    times = np.arange(1, 200) * 1_220_703
    felt = world().ten_dof("U1", preset="adis16407").sample(times, 330.0)
    assert (felt[:, :7] == world().imu("U1", preset="adis16407").sample(times, 330.0)).all()
