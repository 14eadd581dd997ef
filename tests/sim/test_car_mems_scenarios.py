"""The drives that come with the board are what they claim to be."""

import numpy as np
import pytest
from drives import SCENARIOS

from host.sim.scenario.load import load_scenario
from host.sim.world import World

SECOND = 1_000_000_000
SIMULATED = ["town-open", "town", "outages", "rough", "static"]


def truth(name, step_s=1.0, seed=1):
    world = World(load_scenario(SCENARIOS / f"{name}.toml"), seed)
    return world, world.truth(np.arange(0, world.duration_ns, round(step_s * SECOND)))


@pytest.mark.parametrize("name", sorted(p.stem for p in SCENARIOS.glob("*.toml")))
def test_every_scenario_loads(name):
    scenario = load_scenario(SCENARIOS / f"{name}.toml")
    assert scenario.description
    assert scenario.kind == ("recording" if name.startswith("real") else "simulated")


def test_town_open_is_a_drive_through_town():
    world, t = truth("town-open", 0.5)
    speed = np.linalg.norm(t.v_ned, axis=1)
    assert world.duration_ns == 1200 * SECOND
    assert (speed[: 2 * 75] == 0.0).all()
    assert 15.0 < speed.max() < 17.0
    standing = np.flatnonzero(np.diff((speed < 1e-6).astype(int)) == 1)
    assert len(standing) >= 8
    heading = np.unwrap(t.yaw)
    turns = np.abs(heading[20:] - heading[:-20]) > np.radians(60)
    assert np.count_nonzero(np.diff(turns.astype(int)) == 1) >= 15
    assert np.ptp(t.height) > 15.0
    assert np.degrees(t.pitch).max() > 3.0
    lateral = np.abs(np.gradient(heading, 0.5) * speed)
    assert lateral.max() < 4.5  # a car with passengers
    assert not world.outages


def test_tunnels_and_outages_lie_in_the_drive():
    for name, count in (("town", 2), ("outages", 4)):
        world, t = truth(name)
        assert len(world.outages) == count
        speed = np.linalg.norm(t.v_ned, axis=1)
        heading = np.unwrap(t.yaw)
        for o in world.outages:
            assert o.end_ns - o.start_ns == 60 * SECOND
            inside = slice(o.start_ns // SECOND, o.end_ns // SECOND)
            assert speed[inside].mean() > 4.0
            if name == "outages":
                assert np.ptp(heading[inside]) > np.radians(45)


def felt(name):
    world = World(load_scenario(SCENARIOS / f"{name}.toml", ["imu.preset=perfect"]), 1)
    times = 100 * SECOND + np.arange(4000) * 5_000_000
    sample = world.imu("a").sample(times, 100.0)
    return sample - sample.mean(axis=0)


def test_rough_shakes_in_its_band_and_cones():
    frequencies = np.fft.rfftfreq(4000, 0.005)
    spectrum = np.abs(np.fft.rfft(felt("rough")[:, 2] * np.hanning(4000)))
    band = (frequencies > 2.8) & (frequencies < 15.2)
    assert (spectrum[band] ** 2).sum() > 0.9 * (spectrum[frequencies > 0.5] ** 2).sum()
    rates = felt("rough")[:, 3:5].std(axis=0)
    # 0.5° round a cone six times a second: 0.33 rad/s amplitude at full size
    assert rates == pytest.approx([0.33 / np.sqrt(2)] * 2, rel=0.1)
    assert felt("rough")[:, 2].std() > 5 * felt("town-open")[:, 2].std()


def test_a_standing_car_does_not_shake():
    world = World(load_scenario(SCENARIOS / "rough.toml", ["imu.preset=perfect"]), 1)
    sample = world.imu("a").sample(np.arange(1000) * 10_000_000, 50.0)
    assert np.ptp(sample, axis=0).max() < 1e-12


def test_static_stands_still():
    world, t = truth("static", 10.0)
    assert world.duration_ns == 600 * SECOND
    assert (t.v_ned == 0.0).all()
    assert np.degrees([t.yaw[-1], t.pitch[-1], t.roll[-1]]) == pytest.approx([62.0, 1.2, -0.8])


def test_expectations_of_town_are_those_of_the_specification():
    expect = load_scenario(SCENARIOS / "town-open.toml").expect
    assert expect["metrics.velocity_rms_mps"].value == 0.1
    assert expect["metrics.roll_rms_deg"].value == expect["metrics.pitch_rms_deg"].value == 0.5
    assert expect["metrics.yaw_rms_deg"].value == 1.5
    assert expect["metrics.position_horizontal_rms_m"].name == "gnss.position_horizontal_rms_m"
