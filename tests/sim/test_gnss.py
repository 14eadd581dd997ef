"""Simulated receivers: statistics of their errors, outages, faults, sky."""

import math

import numpy as np
import pytest
from standing import SECOND, world

from host.sim.earth import geodetic_to_ecef, rotation_ecef_to_ned
from host.sim.gnss.constellation import sky_at
from host.sim.scenario.errors import ScenarioError

RADIUS = 6.36e6


def moving_world(**tables):
    drive = [
        {"kind": "reach-speed", "duration_s": 10.0, "to_mps": 12.0},
        {"kind": "turn", "duration_s": 30.0, "angle_deg": 200.0},
        {"kind": "cruise", "duration_s": 100.0},
    ]
    return world(segment=drive, duration_s=140.0, **tables)


def errors(w, receiver, seconds):
    """Position error N, E, D in m and velocity error, at 1 Hz."""
    times = np.arange(0, seconds) * SECOND
    truth = w.antenna_truth(times, np.zeros(3))
    epochs = [receiver.epoch(int(t)) for t in times]
    here = rotation_ecef_to_ned(truth.latitude[0], truth.longitude[0])
    true = geodetic_to_ecef(truth.latitude, truth.longitude, truth.height)
    given = geodetic_to_ecef(
        *(np.array([getattr(e, k) for e in epochs]) for k in ("latitude", "longitude", "height"))
    )
    return (given - true) @ here.T, np.array([e.velocity_ned for e in epochs]) - truth.v_ned, epochs


def test_position_error_is_white_plus_gauss_markov():
    position, velocity, epochs = [], [], None
    for seed in range(12):
        w = world(seed, gnss={"position_markov_time_s": 100.0})
        p, v, epochs = errors(w, w.gnss("U3"), 600)
        position.append(p)
        velocity.append(v)
    p, v = np.array(position), np.array(velocity)
    white = np.diff(p, axis=1).std(axis=(0, 1)) / math.sqrt(2)
    slow_step = 1.5 * math.sqrt(1 - math.exp(-1 / 100.0))
    expected = math.hypot(0.5, slow_step)
    assert white == pytest.approx([expected, expected, 1.7 * expected], rel=0.04)
    # 12 runs of 6 correlation times: about 40 independent values
    total = math.hypot(0.5, 1.5)
    assert p.std(axis=(0, 1)) == pytest.approx([total, total, 1.7 * total], rel=0.35)
    assert v.std(axis=(0, 1)) == pytest.approx([0.05] * 3, rel=0.03)
    assert epochs[0].h_acc == pytest.approx(math.sqrt(2) * total)
    assert epochs[0].v_acc == pytest.approx(1.7 * total)
    assert epochs[0].s_acc == pytest.approx(math.sqrt(3) * 0.05)


def test_the_lever_arm_moves_the_antenna():
    quiet = dict.fromkeys(("position_white_m", "position_markov_m", "velocity_white_mps"), 0.0)
    w = world(initial={"yaw_deg": 90.0}, gnss=quiet)
    centre, roof = w.gnss("a").epoch(0), w.gnss("b", np.array([2.0, 0.0, -1.5])).epoch(0)
    # forward is east: two metres east, 1.5 m up
    assert (roof.longitude - centre.longitude) * RADIUS * math.cos(centre.latitude) == pytest.approx(
        2.0, rel=0.01
    )
    assert roof.latitude == pytest.approx(centre.latitude, abs=1e-12)
    assert roof.height - centre.height == pytest.approx(1.5, abs=1e-9)


def test_a_receiver_may_ask_in_any_steps():
    """Truth is computed ahead for equal steps; another step must not get what was meant for the old one."""
    quiet = dict.fromkeys(("position_white_m", "velocity_white_mps"), 0.0)
    w = moving_world(gnss=quiet | {"position_markov_time_s": 20.0})
    steps = [SECOND] * 40 + [SECOND // 5] * 30 + [SECOND // 4, SECOND // 3, 2 * SECOND] + [SECOND] * 20
    lever = np.array([-0.3, 0.1, -1.1])
    receiver, at_once = w.gnss("U3", lever), w.gnss("U3", lever)
    time_ns = 0
    for step_ns in steps:
        time_ns += step_ns
        epoch = receiver.epoch(time_ns)
        truth = w.antenna_truth(np.array([time_ns]), lever)
        assert epoch.velocity_ned == tuple(truth.v_ned[0])
        assert abs(epoch.latitude - truth.latitude[0]) * RADIUS < 10.0
    alone = at_once.epoch(time_ns)
    assert (alone.latitude, alone.longitude, alone.height) == (epoch.latitude, epoch.longitude, epoch.height)


def test_latency_is_drawn_once_a_run():
    latencies = [world(seed).gnss("U3").epoch(0).latency_ns * 1e-9 for seed in range(60)]
    assert np.mean(latencies) == pytest.approx(0.08, abs=0.006)
    assert np.std(latencies) == pytest.approx(0.015, rel=0.35)
    receiver = world(3).gnss("U3")
    assert len({receiver.epoch(k * SECOND).latency_ns for k in range(5)}) == 1
    jittering = world(3, gnss={"latency_jitter_s": 0.004}).gnss("U3")
    assert np.std([jittering.epoch(k * SECOND).latency_ns * 1e-9 for k in range(200)]) == pytest.approx(
        0.004, rel=0.2
    )


def test_an_outage_takes_the_signals_and_recovers_after_its_delay():
    w = world(outage=[{"start_s": 10.0, "duration_s": 20.0}], gnss={"reacquisition_s": 3.0})
    receiver = w.gnss("U3")
    fixes = [receiver.epoch(k * SECOND).fix for k in range(40)]
    assert fixes == [True] * 10 + [False] * 23 + [True] * 7
    inside = world(outage=[{"start_s": 10.0, "duration_s": 20.0}]).gnss("U3").epoch(15 * SECOND)
    assert all(s.cn0_dbhz == 0.0 and not s.used for s in inside.satellites)
    assert inside.hdop == 99.99
    assert inside.time_known
    assert [(o.start_ns, o.end_ns) for o in w.outages] == [(10 * SECOND, 30 * SECOND)]


def test_gps_time_starts_at_the_scenarios_utc():
    w = world(start={"utc": "2024-05-14T08:00:00Z"})
    epoch = w.gnss("U3").epoch(2 * SECOND)
    # 2024-05-14 is 16 200 days after 1980-01-06; 18 leap seconds
    assert epoch.gps_time_ns == ((16_200 * 86_400 + 8 * 3600 + 18) + 2) * SECOND
    assert epoch.leap_seconds == 18


def test_time_and_position_jumps_strike_and_are_counted():
    faults = [
        {
            "kind": "gnss-time-jump",
            "target": "U3",
            "at_s": 5.0,
            "duration_s": 3.0,
            "parameters": {"offset_s": -0.25},
        },
        {"kind": "gnss-position-jump", "target": "U3", "at_s": 20.0, "parameters": {"north_m": 100.0}},
        {"kind": "uart-cut", "target": "U3", "at_s": 1.0},
    ]
    plain, broken = world().gnss("U3"), world(fault=faults).gnss("U3")
    for k in range(30):
        good, bad = plain.epoch(k * SECOND), broken.epoch(k * SECOND)
        assert bad.gps_time_ns - good.gps_time_ns == (-SECOND // 4 if 5 <= k < 8 else 0)
        shift = (bad.latitude - good.latitude) * RADIUS
        assert shift == pytest.approx(100.0 if k >= 20 else 0.0, rel=0.01, abs=1e-6)
    assert [g.fired for g in broken.glitches] == [3, 10]


def test_an_unknown_parameter_of_a_jump_is_named():
    fault = {"kind": "gnss-time-jump", "target": "U3", "at_s": 5.0, "parameters": {"seconds": 1.0}}
    with pytest.raises(ScenarioError, match=r"parameters.seconds = 1.0 is no number known here.*offset_s"):
        world(fault=[fault]).gnss("U3")


@pytest.mark.parametrize("latitude_deg", [-60.0, 0.0, 30.5, 75.0])
def test_the_sky_is_plausible_everywhere(latitude_deg):
    lat = math.radians(latitude_deg)
    for hour in range(0, 24, 3):
        sky = sky_at(1.4e9 + 3600 * hour, lat, 1.0, 100.0, ["GPS", "GLONASS"], math.radians(5))
        assert 14 <= len(sky.satellites) <= 32
        assert 0.4 < sky.hdop < 1.6
        assert sky.hdop < sky.pdop < 3.0
        assert sky.vdop < 2.7
        assert len({(s.system, s.number) for s in sky.satellites}) == len(sky.satellites)
        for s in sky.satellites:
            low, high = (1, 32) if s.system == "GPS" else (65, 96)
            assert low <= s.number <= high
            assert math.radians(5) < s.elevation <= math.pi / 2
            assert 0 <= s.azimuth < 2 * math.pi
            assert 25 < s.cn0_dbhz < 52


def test_dilutions_are_those_of_the_geometry():
    sky = sky_at(1.4e9, 0.5, 1.0, 0.0, ["GPS"], math.radians(5))
    used = [s for s in sky.satellites if s.used]
    sights = np.array(
        [
            [
                math.cos(s.elevation) * math.cos(s.azimuth),
                math.cos(s.elevation) * math.sin(s.azimuth),
                -math.sin(s.elevation),
                1.0,
            ]
            for s in used
        ]
    )
    # independent: covariance from a pseudo-inverse of the same observations
    spread = np.linalg.pinv(sights)
    variance = (spread**2).sum(axis=1)
    assert sky.hdop == pytest.approx(math.sqrt(variance[0] + variance[1]), rel=1e-9)
    assert sky.vdop == pytest.approx(math.sqrt(variance[2]), rel=1e-9)
    assert sky.tdop == pytest.approx(math.sqrt(variance[3]), rel=1e-9)


def test_satellites_move_slowly_and_smoothly():
    first = sky_at(1.4e9, 0.5, 1.0, 0.0, ["GPS"], 0.1)
    later = sky_at(1.4e9 + 60, 0.5, 1.0, 0.0, ["GPS"], 0.1)
    before = {s.number: s for s in first.satellites}
    shared = [s for s in later.satellites if s.number in before]
    assert len(shared) >= len(before) - 1
    assert max(abs(s.elevation - before[s.number].elevation) for s in shared) < math.radians(0.6)


def test_two_receivers_have_errors_of_their_own():
    w = world()
    assert w.gnss("a").epoch(0).latitude != w.gnss("b").epoch(0).latitude
    assert w.gnss("a").epoch(0).latitude == world().gnss("a").epoch(0).latitude
