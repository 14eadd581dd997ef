"""What a sensor of rate, force, field and pressure feels, against scipy and tables of the atmosphere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from pygeomag import GeoMag
from scipy.spatial.transform import Rotation

from host.sim.scenario.load import scenario_from
from host.sim.world import World

SECOND = 1_000_000_000
MODEL = GeoMag(coefficients_file="wmm/WMM_2020.COF")
MOUNTING = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])


def world(
    yaw: float = 0.0,
    pitch: float = 0.0,
    roll: float = 0.0,
    seed: int = 1,
    barometer: dict[str, float] | None = None,
    **place: float,
) -> World:
    data: dict[str, Any] = {
        "place": {"latitude_deg": 47.0, "longitude_deg": 8.0, "height_m": 400.0, "geoid_separation_m": 0.0}
        | place,
        "duration_s": 20.0,
        "initial": {"yaw_deg": yaw, "pitch_deg": pitch, "roll_deg": roll},
        "barometer": barometer or {},
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
    model = MODEL.calculate(glat=latitude, glon=longitude, alt=0.4, time=2024.0 + 134.3 / 366.0)
    expected = (c_nb @ MOUNTING).T @ np.array([model.x, model.y, model.z]) * 1e-9
    assert values[7:10] == pytest.approx(expected, abs=2e-10)
    assert values[10] == pytest.approx(96_611.0, abs=2.0)


@pytest.mark.parametrize(
    ("height", "hpa"),
    [(0.0, 1013.25), (1000.0, 898.76), (3000.0, 701.21), (8000.0, 356.51), (-500.0, 1074.78)],
)
def test_pressure_of_the_standard_atmosphere_above_the_sea(height: float, hpa: float) -> None:
    felt = world(height_m=height + 40.0, geoid_separation_m=40.0).ten_dof("U1", preset="perfect")
    pressure = felt.sample(np.arange(1, 3) * SECOND, 330.0)[:, 10]
    assert pressure == pytest.approx([100.0 * hpa] * 2, rel=2e-5)


def test_the_scenarios_barometer_drifts() -> None:
    errors = {"sea_level_hpa": 1000.0, "bias_pa": 50.0, "drift_pa": 30.0, "drift_time_s": 20.0}
    runs = []
    for seed in range(1, 31):
        felt = world(seed=seed, barometer=errors).ten_dof("U1", preset="perfect")
        runs.append(felt.sample(np.arange(1, 20, 2) * SECOND, 330.0)[:, 10])
    off = np.array(runs) - (96_611.0 * 1000.0 / 1013.25 + 50.0)
    assert abs(off.mean()) < 12.0
    assert off.std() == pytest.approx(30.0, rel=0.25)
    assert np.diff(off, axis=1).std() == pytest.approx(
        30.0 * np.sqrt(2.0 * (1.0 - np.exp(-2.0 / 20.0))), rel=0.15
    )


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
