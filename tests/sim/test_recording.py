"""A real drive behind the simulator's doors (skipped without the recording)."""

import os
from pathlib import Path

import numpy as np
import pytest
from drives import SCENARIOS

from host.sim.earth import geodetic_to_ecef, rotation_ecef_to_ned
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import load_scenario
from host.sim.world import World

DATA = Path(os.environ.get("NAVTWIN_DATA", ""))
FILE = DATA / "comma2k19" / "example_1.npz"
SECOND = 1_000_000_000
present = pytest.mark.skipif(
    not os.environ.get("NAVTWIN_DATA") or not FILE.is_file(),
    reason="no comma2k19/example_1.npz below NAVTWIN_DATA",
)


def world(*overrides):
    return World(load_scenario(SCENARIOS / "real-drive.toml", overrides))


def test_without_a_folder_the_message_says_how_to_give_one(monkeypatch):
    monkeypatch.delenv("NAVTWIN_DATA", raising=False)
    with pytest.raises(ScenarioError, match=r"comma2k19/example_1.npz.*--data DIR.*NAVTWIN_DATA"):
        world()


def test_a_folder_without_the_file_is_named(tmp_path):
    with pytest.raises(ScenarioError, match=r"no such file below .*from --data"):
        World(load_scenario(SCENARIOS / "real-drive.toml"), data_dir=tmp_path)


def test_something_else_than_a_recording_is_refused(tmp_path):
    folder = tmp_path / "comma2k19"
    folder.mkdir()
    (folder / "example_1.npz").write_bytes(b"not an archive")
    with pytest.raises(ScenarioError, match="cannot be read as a NumPy archive"):
        World(load_scenario(SCENARIOS / "real-drive.toml"), data_dir=tmp_path)
    np.savez(folder / "example_1.npz", imu_accel=np.zeros((3, 3)))
    with pytest.raises(ScenarioError, match="not a comma2k19 example, it lacks imu_accel_t"):
        World(load_scenario(SCENARIOS / "real-drive.toml"), data_dir=tmp_path)


@present
@pytest.mark.recording
def test_the_sensor_gives_the_recorded_samples_at_their_instants():
    w = world()
    with np.load(FILE) as archive:
        t, force, rate = archive["imu_accel_t"], archive["imu_accel"], archive["imu_gyro"]
        pose_t, speed = archive["pose_t"], np.linalg.norm(archive["pose_velocity_ecef"], axis=1)
    # virtual time 0 on the recording's clock, found again from the speed of the reference alone
    instants = np.arange(0, 50 * SECOND, SECOND // 4)
    virtual = np.linalg.norm(w.truth(instants).v_ned, axis=1)
    shifts = np.arange(0.0, 1.6, 0.001)
    misfits = [
        np.abs(np.interp(pose_t[0] + s + instants * 1e-9, pose_t, speed) - virtual).max() for s in shifts
    ]
    start = pose_t[0] + shifts[int(np.argmin(misfits))]
    inside = (t > start + 1) & (t < start + 50)
    sample = w.imu("imu", np.diag([1.0, -1.0, -1.0])).sample(
        np.round((t[inside] - start) * SECOND).astype(np.int64), 40.0
    )
    np.testing.assert_allclose(sample[:, :3] * [1, -1, -1], force[inside], atol=0.45)
    difference = sample[:, :3] * [1, -1, -1] - force[inside]
    assert np.sqrt((difference**2).mean()) < 0.1
    assert np.sqrt(((sample[:, 3:6] * [1, -1, -1] - rate[inside]) ** 2).mean()) < 0.01


@present
@pytest.mark.recording
def test_solutions_fit_the_reference_as_well_as_a_constant_shift_allows():
    w = world()
    times = np.arange(0, w.duration_ns, SECOND // 5)
    receiver, truth = w.gnss("gnss"), w.truth(times)
    epochs = [receiver.epoch(int(t)) for t in times]
    assert all(e.fix for e in epochs)
    given = geodetic_to_ecef(
        *(np.array([getattr(e, k) for e in epochs]) for k in ("latitude", "longitude", "height"))
    )
    true = geodetic_to_ecef(truth.latitude, truth.longitude, truth.height)
    error = (given - true) @ rotation_ecef_to_ned(truth.latitude[0], truth.longitude[0]).T
    assert np.sqrt((error[:, :2] ** 2).sum(axis=1).mean()) < 0.5
    velocity = np.array([e.velocity_ned for e in epochs]) - truth.v_ned
    assert np.sqrt((velocity**2).mean(axis=0)) == pytest.approx([0.07, 0.09, 0.09], abs=0.03)
    latency = np.array([e.latency_ns for e in epochs]) * 1e-9
    assert latency.mean() == pytest.approx(0.08, abs=0.003)
    assert 0.004 < latency.std() < 0.02
    assert epochs[0].gps_time_ns % SECOND == 0
    assert epochs[0].geoid_separation == -32.0


@present
@pytest.mark.recording
def test_the_reference_is_consistent_with_itself():
    w = world()
    times = np.arange(0, 50 * SECOND, SECOND // 100)
    t = w.truth(times)
    ecef = geodetic_to_ecef(t.latitude, t.longitude, t.height)
    speed = np.linalg.norm(np.gradient(ecef, 0.01, axis=0), axis=1)
    assert np.abs(speed - np.linalg.norm(t.v_ned, axis=1))[2:-2].max() < 0.15
    assert np.degrees(t.pitch).mean() == pytest.approx(-4.0, abs=1.0)
    assert np.degrees(t.roll).mean() == pytest.approx(1.4, abs=0.7)
    course = np.arctan2(t.v_ned[:, 1], t.v_ned[:, 0])
    assert np.degrees(np.abs((t.yaw - course + np.pi) % (2 * np.pi) - np.pi)).max() < 3.0
    assert np.isnan(t.bias_g).all()


@present
@pytest.mark.recording
def test_cuts_take_the_fix_for_their_ten_seconds():
    w = World(load_scenario(SCENARIOS / "real-drive-cuts.toml"))
    receiver = w.gnss("gnss")
    times = np.arange(0, w.duration_ns, SECOND // 5)
    fixes = np.array([receiver.epoch(int(t)).fix for t in times])
    starts = [o.start_ns for o in w.outages]
    assert len(starts) == 4
    for t, fix in zip(times, fixes, strict=True):
        assert fix == (not any(s <= t < s + 10 * SECOND for s in starts))


@present
@pytest.mark.recording
def test_a_run_longer_than_the_recording_is_refused():
    with pytest.raises(
        ScenarioError, match=r"duration_s = 90: the recording .* lasts 58.9 s; for example duration_s"
    ):
        world("duration_s=90.0")
