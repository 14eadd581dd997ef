"""comma2k19 and BROAD arrays: real ones where there are any, written ones, and wrong ones."""

import json
import math

import numpy as np
import pytest
from circle_drive import GRAVITY, at_rate
from imports import imported, kinds, navtwin, recording, refused, rows
from scipy.spatial.transform import Rotation

from host.record.result import RunRequest
from host.run.runner import run

EXAMPLE = "comma2k19/example_1.npz"
NO_LEVER = ("--set", "board.chips.U3.lever_arm_m=[0.0,0.0,0.0]")


def test_the_real_drive_is_the_same_imported_and_as_a_scenario(tmp_path):
    source = recording(EXAMPLE)
    report, capture = imported(tmp_path, "comma2k19", source, options=["--accuracy", "1.0,2.2,0.15"])
    assert report["begins"] == "2018-08-02T16:14:48Z"
    assert set(kinds(report)) == {("gap", "/gnss")}
    outcome = navtwin(
        *("replay", capture, "--board", "car_mems", "--mode", "physical", "-q", "--json", "-", *NO_LEVER),
        *("--set", "profile.gnss_rate_hz=5"),
    )
    assert outcome.exit_code == 0, outcome.output
    replayed = json.loads(outcome.stdout)
    direct = run(RunRequest("car_mems", "real-drive", seed=1))
    assert replayed["scored_against"] == "truth"
    for name, tolerance in (
        ("position_horizontal_rms_m", 0.005),
        ("position_vertical_rms_m", 0.005),
        ("velocity_rms_mps", 0.001),
        ("yaw_rms_deg", 0.02),
        ("roll_rms_deg", 0.02),
    ):
        assert replayed["metrics"][name] == pytest.approx(direct.metrics[name], abs=tolerance)
    assert replayed["gnss"]["position_horizontal_rms_m"] == pytest.approx(
        direct.gnss["position_horizontal_rms_m"], abs=1e-3
    )


def test_the_arrays_are_kept_as_they_are(tmp_path):
    source = recording(EXAMPLE)
    _, capture = imported(tmp_path, "comma2k19", source)
    data = np.load(source)
    samples = rows(capture, "/imu/imu")
    assert [row["force_x_mps2"] for row in samples] == pytest.approx(data["imu_accel"][:, 0], abs=1e-7)
    steps = np.diff([row["t_s"] for row in samples])
    assert steps == pytest.approx(np.diff(data["imu_accel_t"]), abs=2e-9 * 100)
    assert len(rows(capture, "/speed/wheels")) == len(data["wheel_speed"])
    truth = rows(capture, "/truth")[600]
    v = (
        Rotation.from_quat(data["pose_orientation_ecef"][600], scalar_first=True)
        .inv()
        .apply(data["pose_velocity_ecef"][600])
    )
    assert math.hypot(truth["v_north_mps"], truth["v_east_mps"], truth["v_down_mps"]) == pytest.approx(
        np.linalg.norm(v), abs=1e-4
    )


def test_a_real_trial_of_broad(tmp_path):
    source = recording("broad/30_disturbed_stationary_magnet_C.npz")
    report, capture = imported(tmp_path, "broad", source)
    data = np.load(source)
    attitudes = rows(capture, "/attitude")
    seen = np.flatnonzero(np.isfinite(data["opt_quat"]).all(axis=1))
    assert len(attitudes) == len(seen)
    k = len(seen) // 2
    enu = Rotation.from_quat(data["opt_quat"][seen[k]], scalar_first=True)
    ned = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]) @ enu.as_matrix()
    told = attitudes[k]
    quaternion = [told[f"q_{axis}"] for axis in "wxyz"]
    assert Rotation.from_quat(quaternion, scalar_first=True).as_matrix() == pytest.approx(ned, abs=1e-6)
    yaw, pitch, roll = Rotation.from_matrix(ned).as_euler("ZYX", degrees=True)
    assert (told["yaw_deg"], told["pitch_deg"]) == pytest.approx((yaw % 360.0, pitch), abs=1e-3)
    assert (told["roll_deg"] - roll + 180) % 360 - 180 == pytest.approx(0.0, abs=1e-3)
    assert told["t_s"] == pytest.approx(seen[k] / 285.7142857, abs=1e-6)
    assert report["topics"]["/imu/imu"] == len(data["imu_acc"])
    assert "no physical replay: there is no receiver in it" in report["uses"]


def broad(**changes):
    n = 600
    drive = at_rate(100.0, 6.0)
    quaternion = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    quaternion[:50] = np.nan
    arrays = {
        "sampling_rate_hz": 100.0,
        "imu_acc": -drive.force,
        "imu_gyr": drive.rate,
        "imu_mag": np.random.default_rng(1).standard_normal((n, 3)) + 20.0,
        "opt_quat": quaternion,
        "movement": np.arange(n) > 300,
    }
    return {name: value for name, value in (arrays | changes).items() if value is not None}


def test_a_written_trial(tmp_path):
    np.savez(tmp_path / "x.npz", **broad())
    report, capture = imported(tmp_path, "broad", tmp_path / "x.npz")
    assert kinds(report) == {("missing", "opt_quat"): 50}
    first = rows(capture, "/attitude")[0]
    assert first["t_s"] == 0.5
    assert (first["yaw_deg"], first["pitch_deg"], abs(first["roll_deg"])) == pytest.approx((90.0, 0.0, 180.0))
    assert [row["moving"] for row in rows(capture, "/movement")] == [0, 1]
    assert np.mean([row["force_z_mps2"] for row in rows(capture, "/imu/imu")]) == pytest.approx(
        GRAVITY, abs=0.01
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"imu_acc": None}, "it lacks imu_acc"),
        ({"imu_gyr": np.zeros((600, 2))}, "imu_gyr has the shape (600, 2)"),
        ({"imu_gyr": np.zeros((6, 3))}, "differ in length"),
        ({"sampling_rate_hz": 0.0}, "cannot be; BROAD has 285.71"),
        (
            {"imu_gyr": np.full((600, 3), 70.0)},
            "it looks like deg/s; state the right one with --unit gyro=deg/s",
        ),
        ({"imu_acc": np.tile([0.0, 0.0, 1.0], (600, 1))}, "--unit accel=g"),
    ],
)
def test_arrays_that_cannot_be_are_refused(tmp_path, changes, message):
    np.savez(tmp_path / "x.npz", **broad(**changes))
    assert message in refused(tmp_path, "broad", tmp_path / "x.npz")


def test_other_files_are_refused(tmp_path):
    np.save(tmp_path / "one.npy", np.zeros(3))
    (tmp_path / "text.npz").write_text("hello")
    np.savez(tmp_path / "objects.npz", **broad(imu_acc=np.array([{}], dtype=object)))
    assert "is a single array" in refused(tmp_path, "broad", tmp_path / "one.npy")
    for kind in ("broad", "comma2k19"):
        assert "cannot be read as a NumPy archive" in refused(tmp_path, kind, tmp_path / "text.npz")
    assert "cannot be read as a NumPy archive" in refused(tmp_path, "broad", tmp_path / "objects.npz")
    np.savez(tmp_path / "x.npz", **broad())
    assert "not comma2k19 arrays, it lacks imu_accel_t" in refused(tmp_path, "comma2k19", tmp_path / "x.npz")


def test_stuck_channels_and_nothings_are_told(tmp_path):
    arrays = broad()
    arrays["imu_gyr"][100:400, 1] = 0.25
    arrays["imu_acc"][450] = np.nan
    np.savez(tmp_path / "x.npz", **arrays)
    report, capture = imported(tmp_path, "broad", tmp_path / "x.npz")
    found = kinds(report)
    assert found[("stuck channel", "/imu/imu rate_y_dps")] == 1
    assert found[("gap", "/imu/imu")] == 1
    assert len(rows(capture, "/imu/imu")) == 599
