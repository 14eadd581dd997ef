"""Composite motions: what each one says it does, smooth joints, and messages for impossible ones."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import scenario_from
from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.joints import examine

SECOND = 1_000_000_000
G = 9.80665
PLACE = {"latitude_deg": 30.0, "longitude_deg": 114.0, "height_m": 20.0}

COMPOSITES: list[tuple[dict[str, Any], float]] = [
    ({"kind": "s-curve", "duration_s": 20.0, "angle_deg": 60.0}, 10.0),
    ({"kind": "l-shape", "duration_s": 30.0}, 10.0),
    ({"kind": "cross", "duration_s": 80.0}, 5.0),
    ({"kind": "figure-eight", "duration_s": 60.0}, 10.0),
    ({"kind": "rotary-table"}, 0.0),
    ({"kind": "coning", "duration_s": 20.0, "half_angle_deg": 1.0, "frequency_hz": 2.0}, 0.0),
    (
        {
            "kind": "sculling",
            "duration_s": 20.0,
            "amplitude_mps2": 5.0,
            "angle_deg": 1.0,
            "frequency_hz": 2.0,
        },
        0.0,
    ),
    ({"kind": "banked-turn", "duration_s": 30.0, "angle_deg": -90.0}, 60.0),
    ({"kind": "aircraft", "duration_s": 600.0}, 0.0),
    ({"kind": "ship", "duration_s": 300.0}, 6.0),
    ({"kind": "shell"}, 0.0),
    ({"kind": "cruise", "duration_s": 10.0, "pitch_rate_dps": 0.5, "roll_rate_dps": -2.0}, 10.0),
]


def vehicle(*segments: dict[str, Any], speed: float = 0.0) -> SimulatedVehicle:
    data = {"place": PLACE, "initial": {"speed_mps": speed, "yaw_deg": 40.0}, "segment": [*segments]}
    return SimulatedVehicle(scenario_from(data, "t", "t.toml"), 1)


def course(made: SimulatedVehicle, step_ms: int = 10) -> Any:
    return made.truth(np.arange(0, made.duration_ns + 1, step_ms * 1_000_000))


@pytest.mark.parametrize(
    ("segment", "speed"), COMPOSITES, ids=lambda one: str(getattr(one, "get", str)("kind"))
)
def test_composites_join_what_stands_around_them_smoothly(segment: dict[str, Any], speed: float) -> None:
    """Speed, angles and their rates have no step anywhere, neither inside nor at the ends."""
    around = {"kind": "cruise", "duration_s": 2.0}
    made = vehicle(around, segment, around, speed=speed)
    found = examine(made.motion.channels)
    assert found.steps == ()
    assert found.largest_value_step < 1e-7
    rows = made.motion.rows(np.arange(0, made.duration_ns, SECOND // 1000))
    largest = np.abs(np.diff(rows[:, 15:21], axis=0)).max(axis=0)
    fine = made.motion.rows(np.arange(0, made.duration_ns, SECOND // 2000))
    halved = np.abs(np.diff(fine[:, 15:21], axis=0)).max(axis=0)
    # a step would be as large at twice the rate
    assert np.all(halved < 0.6 * largest + 1e-6)


def test_steps_of_the_numeric_form_are_told_and_counted() -> None:
    data = {"place": PLACE, "trajectory": {"matrix": [[1, 5], [4, 10, 2, 0], [8, 10, 6, 0], [1, 5]]}}
    made = SimulatedVehicle(scenario_from(data, "t", "t.toml"), 1)
    told = [(step.at_s, step.what, round(step.size, 9)) for step in examine(made.motion.channels).steps]
    rate = round(math.radians(6.0), 9)
    assert told == [
        (5.0, "acceleration", 2.0),
        (15.0, "acceleration", -2.0),
        (15.0, "turn rate", rate),
        (25.0, "turn rate", -rate),
    ]


def test_the_stated_jerk_is_that_of_the_path() -> None:
    """|jerk| ≤ 1.875 max|a| / blend for a speed change with flanks."""
    made = vehicle({"kind": "reach-speed", "duration_s": 8.0, "to_mps": 15.0})
    stated = examine(made.motion.channels).largest_jerk_mps3
    speed = np.linalg.norm(course(made, 1).v_ned, axis=1)
    assert stated == pytest.approx(np.abs(np.diff(speed, 2)).max() / 1e-6, rel=1e-3)
    assert stated == pytest.approx(1.875 * 15.0 / 7.5 / 0.5, rel=1e-3)


def test_turning_composites_turn_by_what_they_say() -> None:
    for segment, speed, angle in (
        (COMPOSITES[0][0], 10.0, 0.0),
        ({"kind": "l-shape", "duration_s": 30.0, "angle_deg": -45.0}, 10.0, -45.0),
        (COMPOSITES[2][0], 5.0, 360.0),
        (COMPOSITES[3][0], 10.0, 0.0),
        (COMPOSITES[7][0], 60.0, -90.0),
    ):
        yaw = np.unwrap(course(vehicle(segment, speed=speed)).yaw)
        assert np.degrees(yaw[-1] - yaw[0]) == pytest.approx(angle, abs=1e-8)
    eight = np.unwrap(course(vehicle(COMPOSITES[3][0], speed=10.0)).yaw)
    assert np.degrees(eight.max() - eight[0]) == pytest.approx(360.0, abs=1e-6)
    left = np.unwrap(course(vehicle({**COMPOSITES[3][0], "first": "left"}, speed=10.0)).yaw)
    np.testing.assert_allclose(left - left[0], eight[0] - eight, atol=1e-12)


def test_a_rotary_table_dwells_in_its_positions() -> None:
    positions = [[0.0, 90.0, 0.0], [30.0, 0.0, 180.0], [-90.0, -90.0, 0.0]]
    made = vehicle({"kind": "rotary-table", "positions_deg": positions, "dwell_s": 10.0, "move_s": 2.0})
    assert made.duration_ns == 36 * SECOND
    for number, (yaw, pitch, roll) in enumerate(positions):
        during = made.motion.rows(np.array([12 * number + 3, 12 * number + 11]) * SECOND)
        np.testing.assert_allclose(during[0, 15:21], during[1, 15:21], atol=1e-12)
        y, p, r = math.radians(40.0 + yaw), math.radians(pitch), math.radians(roll)
        down = [-math.sin(p), math.sin(r) * math.cos(p), math.cos(r) * math.cos(p)]
        gravity = np.linalg.norm(during[0, 18:21])
        np.testing.assert_allclose(during[0, 18:21], [-gravity * d for d in down], atol=1e-9)
        assert during[0, 6] == pytest.approx(math.cos(p) * math.cos(y), abs=1e-12)


def test_a_banked_turn_does_not_slip() -> None:
    """On the plateau the bank is atan(v ω / g); across, only what the Earth's turn makes is felt."""
    made = vehicle(COMPOSITES[7][0], speed=60.0)
    row = made.motion.rows(np.array([15 * SECOND]))[0]
    roll = math.atan2(row[13], row[14])
    rate = -math.radians(90.0) / 22.5
    assert roll == pytest.approx(math.atan(60.0 * rate / G), rel=1e-12)
    assert abs(row[19]) < 0.02


def test_a_shell_flies_its_parabola_and_feels_nothing() -> None:
    made = vehicle({"kind": "shell", "spin_turns": 3.0})
    start, flight = 6.2, 2.0 * 100.0 * 0.5 / G
    assert made.duration_ns == pytest.approx((7.4 + flight) * SECOND)
    t = start + np.linspace(0.0, flight, 200)[1:-1]
    truth = made.truth(np.round(t * SECOND).astype(np.int64))
    up = 50.0 - G * (t - start)
    np.testing.assert_allclose(-truth.v_ned[:, 2], up, atol=1e-6)
    np.testing.assert_allclose(
        np.hypot(truth.v_ned[:, 0], truth.v_ned[:, 1]), 100.0 * math.cos(math.pi / 6), atol=1e-6
    )
    risen = 50.0 * (t - start) - 0.5 * G * (t - start) ** 2
    np.testing.assert_allclose(truth.height - truth.height[0], risen - risen[0], atol=1e-5)
    felt = made.motion.rows(np.round(t * SECOND).astype(np.int64))[:, 18:21]
    assert np.abs(felt).max() < 0.05, "what is left: local gravity is not 9.80665, and Coriolis"


def test_a_ship_swings_by_its_angles() -> None:
    truth = course(vehicle(COMPOSITES[9][0], speed=6.0))
    assert np.degrees(np.abs(truth.roll).max()) == pytest.approx(8.0, rel=1e-2)
    assert np.degrees(np.abs(truth.pitch).max()) == pytest.approx(3.0, rel=1e-2)
    yaw = np.degrees(np.unwrap(truth.yaw))
    assert (yaw.max() - yaw.min()) / 2 == pytest.approx(2.0, rel=0.05)
    assert (truth.roll[-1], truth.pitch[-1], yaw[-1]) == pytest.approx((0.0, 0.0, 40.0), abs=1e-7)


def test_coning_leaves_the_drift_of_the_book() -> None:
    """ω_z rectifies into −½ α² Ω for small α (Goodman & Robinson); roll and pitch come back."""
    made = vehicle(COMPOSITES[5][0])
    times = np.arange(5 * SECOND, 15 * SECOND, 1_000_000)
    rows = made.motion.rows(times)
    earth = (rows[:, 6:15].reshape(-1, 3, 3).transpose(0, 2, 1) @ _earth_rate(30.0))[:, 2]
    drift = (rows[:, 17] - earth).mean()
    alpha, omega = math.radians(1.0), 4.0 * math.pi
    assert abs(drift) == pytest.approx(0.5 * alpha**2 * omega, rel=1e-3)


def _earth_rate(latitude_deg: float) -> Any:
    lat = math.radians(latitude_deg)
    return np.array([7.292115e-5 * math.cos(lat), 0.0, -7.292115e-5 * math.sin(lat)])


def test_an_aircraft_comes_back_to_rest_on_its_height() -> None:
    truth = course(vehicle(COMPOSITES[8][0]), 100)
    speed = np.linalg.norm(truth.v_ned, axis=1)
    assert speed.max() == pytest.approx(70.0, abs=1e-9)
    assert speed[-1] == pytest.approx(0.0, abs=1e-9)
    assert truth.height.max() > 500.0
    # climb and descent are alike but for the Earth's curvature below 25 km of path
    assert truth.height[-1] == pytest.approx(20.0, abs=0.01)


@pytest.mark.parametrize(
    ("segment", "speed", "words"),
    [
        ({"kind": "rotary-table"}, 3.0, "begins at 3 m/s; stop first"),
        ({"kind": "shell"}, 3.0, "begins at 3 m/s"),
        ({"kind": "aircraft", "duration_s": 100.0}, 3.0, "begins at 3 m/s"),
        ({"kind": "banked-turn", "duration_s": 2.0, "angle_deg": 180.0}, 60.0, "needs a bank of"),
        ({"kind": "s-curve", "duration_s": -1.0, "angle_deg": 1.0}, 3.0, "duration_s"),
        ({"kind": "rotary-table", "positions_deg": [[0.0, 0.0]]}, 0.0, "positions_deg"),
        ({"kind": "rotary-table", "positions_deg": [[0.0, 200.0, 0.0]]}, 0.0, "180"),
        (
            {"kind": "coning", "duration_s": 1.0, "half_angle_deg": 1.0, "frequency_hz": 0.0},
            0.0,
            "frequency_hz",
        ),
        ({"kind": "shell", "elevation_deg": 90.0}, 0.0, "elevation_deg"),
        (
            {"kind": "cruise", "duration_s": 1.0, "pitch_to_deg": 1.0, "pitch_rate_dps": 1.0},
            1.0,
            "exclude each other",
        ),
    ],
)
def test_impossible_composites_are_one_message(segment: dict[str, Any], speed: float, words: str) -> None:
    with pytest.raises(ScenarioError, match=words) as caught:
        vehicle(segment, speed=speed)
    assert str(caught.value).startswith("t")
    assert "segment[1]" in str(caught.value)
