"""Segments do what they say, join smoothly, and the numeric form follows its document."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import scenario_from
from host.sim.scenario.motion_matrix import segment_of_row
from host.sim.scenario.motion_schema import Rest
from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.motion import Motion
from host.sim.trajectory.segments import MotionState

SECOND = 1_000_000_000
ORIGIN = (0.5, 1.0, 10.0)

ROWS = [
    ([2, 8, 6, 0], 6.0, 0.0),
    ([3, 8, 12, 0], 2.0, 0.0),
    ([4, 5, 1.5, 0], 7.5, 0.0),
    ([5, 12, 1.0, 4], 0.0, 0.0),
    ([5, 10, 1.0, 8], 4.0 / math.pi * (1 - math.cos(2.5 * math.pi)), 0.0),
    ([6, 6, -1, 2], 3.0, 0.0),
    ([7, 8, 0, 90], 0.0, 90.0),
    ([7, 8, 0, -135], 0.0, -135.0),
    ([8, 20, 12, 0], 0.0, 240.0),
    ([9, 6, 12, 10], 0.0, 10 * 12 / math.pi),
    ([91, 7, 12, 10], 0.0, 10 * 6 / math.pi * math.sin(2 * math.pi * 7 / 12)),
    ([10, 5, 4, 10], 0.0, 35.0),
]


def drive(rows, blend_s, speed=10.0):
    segments = [segment_of_row(row) for row in rows]
    return Motion(segments, MotionState(speed, 0.3), ORIGIN, blend_s)


def speed_and_yaw(motion, times_ns):
    r = motion.rows(np.asarray(times_ns, dtype=np.int64))
    speed = np.linalg.norm(r[:, 3:6], axis=1)
    return speed, np.unwrap(np.arctan2(r[:, 9], r[:, 6])), r


@pytest.mark.parametrize("blend_s", [0.0, 0.5, 3.0])
@pytest.mark.parametrize(("row", "speed_change", "angle_deg"), ROWS)
def test_a_segment_changes_speed_and_heading_by_what_it_says(row, speed_change, angle_deg, blend_s):
    m = drive([row], blend_s)
    assert m.end_ns == row[1] * SECOND
    times = np.arange(0, m.end_ns + 1, 10_000_000)
    speed, yaw, _ = speed_and_yaw(m, times)
    assert speed[-1] - 10.0 == pytest.approx(speed_change, abs=1e-9)
    assert np.degrees(yaw[-1] - yaw[0]) == pytest.approx(angle_deg, abs=1e-8)


@pytest.mark.parametrize(("row", "speed_change", "angle_deg"), ROWS)
def test_blended_segments_join_without_a_step(row, speed_change, angle_deg):
    """Velocity, attitude, acceleration and rate meet at every joint, to rounding."""
    m = drive([[1, 2], row, row, [1, 2]], 0.5)
    for joint_s in (2, 2 + row[1], 2 + 2 * row[1]):
        before, after = m.rows(np.array([joint_s * SECOND - 1, joint_s * SECOND]))
        # one nanosecond of motion at 20 m/s² and 3 rad/s² lies between the two
        np.testing.assert_allclose(after[3:6], before[3:6], atol=3e-8)
        np.testing.assert_allclose(after[6:18], before[6:18], atol=1e-8)
        np.testing.assert_allclose(after[18:21], before[18:21], atol=3e-7)


@pytest.mark.parametrize(
    ("row", "top", "own_slope"),
    [
        ([4, 5, 1.5, 0], 1.5 * 5 / 4.5, 0.0),
        ([2, 8, 6, 0], 6 / 7.5, 0.0),
        ([5, 12, 1.0, 4], 1.0, 2 * math.pi / 4),
        ([6, 6, -1, 2], 2 + 0.5 * 0.5 / 5.5, 3 / 6),
    ],
)
def test_jerk_stays_within_the_stated_bound(row, top, own_slope):
    """|jerk| ≤ 1.875 max|a₀ + c| / blend + max|ȧ₀|; c keeps the speed change (constant c for the ramp: its
    mean 0.5 m/s² times what the flanks take away)."""
    blend = 0.5
    m = drive([row], blend)
    times = np.arange(0, m.end_ns, 2_000_000)
    speed, _, _ = speed_and_yaw(m, times)
    jerk = np.diff(speed, 2) / 2e-3**2
    assert np.abs(jerk).max() <= (1.875 * top / blend + own_slope) * 1.001
    assert np.abs(jerk).max() > 0.5 * 1.875 * top / blend or row[0] == 5


def test_the_numeric_turn_follows_equations_3_9_to_3_13():
    t, angle = 8.0, math.radians(90)
    m = drive([[7, t, 0, 90]], 0.0)
    t1 = 0.25 * t
    k = 4 * angle / (t**3 * 0.25**2 * 0.75)
    times = np.linspace(0.0, t, 801)
    _, yaw, _ = speed_and_yaw(m, np.round(times * SECOND))
    rate = np.interp(times, times, np.gradient(yaw, times))
    expected = np.where(
        times <= 0.5 * t1,
        0.5 * k * times**2,
        np.where(times <= t1, k * t1 * times - 0.25 * k * t1**2 - 0.5 * k * times**2, 0.25 * k * t1**2),
    )
    half = times <= t / 2
    np.testing.assert_allclose(rate[half][1:], expected[half][1:], atol=2e-4)
    assert yaw[-1] - yaw[0] == pytest.approx(angle, rel=1e-12)


def test_the_numeric_form_steps_where_its_document_steps():
    m = drive([[1, 2], [4, 3, 2.0, 0], [1, 2]], 0.0)
    before, after = m.rows(np.array([2 * SECOND - 1, 2 * SECOND]))
    assert after[18] - before[18] == pytest.approx(2.0, abs=1e-6)
    assert after[3] == pytest.approx(before[3], abs=1e-7)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.one_of(
            st.tuples(st.just(7), st.floats(2, 20), st.just(0.0), st.floats(-180, 180)),
            st.tuples(st.just(3), st.floats(2, 20), st.floats(0, 30), st.just(0.0)),
            st.tuples(st.just(9), st.floats(2, 20), st.floats(2, 20), st.floats(-20, 20)),
        ),
        min_size=1,
        max_size=6,
    )
)
def test_any_drive_ends_where_its_segments_lead(rows):
    m = drive(rows, 0.4)
    speed, _, r = speed_and_yaw(m, [m.end_ns])
    wanted = next((row[2] for row in reversed(rows) if row[0] == 3), 10.0)
    assert speed[0] == pytest.approx(wanted, abs=1e-9)
    assert r[0, 5] == pytest.approx(0.0, abs=1e-12)


def test_pitch_targets_make_a_hill():
    data = {
        "place": {"latitude_deg": 10.0, "longitude_deg": 20.0, "height_m": 5.0},
        "initial": {"speed_mps": 10.0},
        "segment": [
            {"kind": "cruise", "duration_s": 10.0, "pitch_to_deg": 5.0},
            {"kind": "cruise", "duration_s": 20.0},
            {"kind": "cruise", "duration_s": 10.0, "pitch_to_deg": 0.0},
        ],
    }
    vehicle = SimulatedVehicle(scenario_from(data, "hill", "hill"), 1)
    truth = vehicle.truth(np.array([0, 20, 40]) * SECOND)
    assert np.degrees(truth.pitch) == pytest.approx([0.0, 5.0, 0.0], abs=1e-9)
    # both ramps climb like half of the plateau, by their symmetry, but for the sine's curvature
    assert truth.height[2] - 5.0 == pytest.approx(10.0 * 30.0 * math.sin(math.radians(5)), rel=1e-3)
    assert truth.v_ned[1, 2] == pytest.approx(-10.0 * math.sin(math.radians(5)), rel=1e-9)


def test_rest_at_speed_is_refused_with_the_way_out():
    with pytest.raises(ValueError, match=r"kind 'rest' begins at 7 m/s.*reach-speed"):
        Motion([Rest(kind="rest", duration_s=5.0)], MotionState(7.0), ORIGIN)


def test_an_unknown_type_code_names_the_known_ones():
    with pytest.raises(ValueError, match=r"type code 11 is not one of 1 … 10, 91"):
        segment_of_row([11, 5, 0, 0])


def test_position_passes_steps_of_acceleration_without_a_trace():
    """Along the equator the way is the longitude times one radius, and the integral of the speed on paper."""
    segments = [segment_of_row(row) for row in ([4, 1.2345, 5.0, 0], [4, 2.0071, -3.0, 0], [1, 2.0])]
    m = Motion(segments, MotionState(20.0, math.pi / 2), (0.0, 1.0, 10.0), 0.0)
    times = np.arange(0, m.end_ns, 1_003_001)
    t = times / SECOND
    first, second = np.clip(t, 0.0, 1.2345), np.clip(t - 1.2345, 0.0, 2.0071)
    last = np.clip(t - 1.2345 - 2.0071, 0.0, None)
    middle_mps = 20.0 + 5.0 * 1.2345
    way = 20.0 * first + 2.5 * first**2 + middle_mps * second - 1.5 * second**2
    way += (middle_mps - 3.0 * 2.0071) * last
    assert np.abs((m.rows(times)[:, 1] - 1.0) * (6378137.0 + 10.0) - way).max() < 2e-8


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        (
            {"segment": [{"kind": "speed-change", "duration_s": 5.0, "by_mps": -2.0}]},
            r"segment\[1\]: brings the speed down to -2 m/s; a vehicle stops at 0, for example by",
        ),
        (
            {
                "segment": [
                    {"kind": "rest", "duration_s": 5.0},
                    {"kind": "acceleration-ramp", "duration_s": 4.0, "from_mps2": -2.0, "to_mps2": 2.0},
                ]
            },
            r"segment\[2\]: brings the speed down to",
        ),
        (
            {"trajectory": {"matrix": [[1, 10], [4, 10, -3]]}},
            r"trajectory.matrix\[2\]: brings the speed down to -30",
        ),
        (
            {
                "segment": [{"kind": "cruise", "duration_s": 100.0, "pitch_rate_dps": 2.0}],
                "initial": {"speed_mps": 9.0},
            },
            r"segment\[1\]: brings the pitch to 200°; what moves keeps within ±90°",
        ),
    ],
)
def test_impossible_motion_is_one_message(motion, words):
    place = {"latitude_deg": 30.0, "longitude_deg": 114.0}
    with pytest.raises(ScenarioError, match=words):
        SimulatedVehicle(scenario_from({"place": place, **motion}, "drive", "drive"), 1)


@pytest.mark.parametrize(
    "segment",
    [
        {"kind": "rest", "duration_s": 100.0, "pitch_rate_dps": 4.0},
        {"kind": "surge", "duration_s": 3.0, "amplitude_mps2": -1.0, "period_s": 4.0},
    ],
)
def test_a_rotary_table_may_turn_over_and_what_swings_may_swing_back(segment):
    data = {"place": {"latitude_deg": 30.0, "longitude_deg": 114.0}, "segment": [segment]}
    duration_ns = SimulatedVehicle(scenario_from(data, "t", "t"), 1).duration_ns
    assert duration_ns == segment["duration_s"] * SECOND


def test_a_vehicle_backs_at_a_speed_that_is_named():
    """From rest to −4 m/s over 4 s, on for 5 s, to rest over 4 s: 36 m back, as far as forwards."""
    way = {}
    for speed in (4.0, -4.0):
        segments = [
            {"kind": "rest", "duration_s": 2.0},
            {"kind": "reach-speed", "duration_s": 4.0, "to_mps": speed},
            {"kind": "cruise", "duration_s": 5.0},
            {"kind": "reach-speed", "duration_s": 4.0, "to_mps": 0.0},
            {"kind": "rest", "duration_s": 2.0},
        ]
        data = {"place": {"latitude_deg": 0.0, "longitude_deg": 114.0}, "segment": segments}
        vehicle = SimulatedVehicle(scenario_from(data, "t", "t"), 1)
        latitude = vehicle.truth(np.array([0, vehicle.duration_ns], np.int64)).latitude
        way[speed] = (latitude[1] - latitude[0]) * 6_335_439.0
    assert way[4.0] == pytest.approx(36.0, abs=1e-3)
    assert way[-4.0] == pytest.approx(-36.0, abs=1e-3)
