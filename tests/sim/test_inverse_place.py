"""`navtwin inverse` with its inertial sensor off the trajectory's points and turned in the body."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import ecef_mechanization as oracle
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner, Result

from host.cli.main import app

ARM_M = (2.0, -1.0, 0.5)
TURNED_DEG = (30.0, 40.0, -100.0)
PLACED = ("--imu-at", ",".join(map(str, ARM_M)), "--mounting", ",".join(map(str, TURNED_DEG)))
DRIVE = """
segment = [
  { kind = "reach-speed", duration_s = 6.0, to_mps = 9.0 },
  { kind = "turn", duration_s = 8.0, angle_deg = 90.0, pitch_to_deg = 10.0 },
  { kind = "weave", duration_s = 12.0, amplitude_dps = 20.0, period_s = 6.0 },
]
place = { latitude_deg = 47.0, longitude_deg = 8.0, height_m = 400.0 }
imu = { preset = "perfect" }
"""


def navtwin(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(one) for one in arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """truth.npz of the drive, felt.npz as simulated where the sensor sits, found.npz by the inverse."""
    place = tmp_path_factory.mktemp("placed")
    (place / "drive.toml").write_text(DRIVE)
    commands = (
        ("simulate", place / "drive.toml", "-o", place / "truth.npz"),
        ("simulate", place / "drive.toml", "-o", place / "felt.npz", "--samples", "increment", *PLACED),
        ("inverse", place / "truth.npz", "-o", place / "found.npz", *PLACED, "--json", place / "told.json"),
    )
    for words in commands:
        result = navtwin(*words, "-q")
        assert result.exit_code == 0, result.output
    return place


def table(folder: Path, name: str) -> Any:
    return np.load(folder / f"{name}.npz")["imu"]


def test_the_loop_closes_where_the_sensor_sits(folder: Path) -> None:
    told = json.loads((folder / "told.json").read_text())
    assert told["closure"]["position_rms_m"] <= 1e-5
    assert told["closure"]["velocity_rms_mps"] <= 1e-6
    assert told["closure"]["attitude_rms_deg"] <= 1e-7
    assert (told["imu_at_m"], told["mounting_deg"]) == (list(ARM_M), pytest.approx(TURNED_DEG))


def test_increments_are_those_that_the_simulator_feels_there(folder: Path) -> None:
    """Found from positions of the point; felt by ω̇ × l + ω × (ω × l) and how gravity changes over the arm."""
    felt, found = table(folder, "felt"), table(folder, "found")
    np.testing.assert_allclose(found["dtheta"], felt["dtheta"], atol=1e-11)
    np.testing.assert_allclose(found["dv"], felt["dv"], atol=1e-6)
    assert np.abs(found["dv"].sum(axis=0) - felt["dv"].sum(axis=0)).max() < 2e-6


def test_reference_is_that_of_the_trajectorys_points(folder: Path) -> None:
    truth, found = table(folder, "truth")[1:], table(folder, "found")
    assert np.abs(found["latitude"] - truth["latitude"]).max() * 6.4e6 < 1e-5
    assert np.abs(found["height"] - truth["height"]).max() < 1e-5
    assert np.abs(found["velocity"] - truth["velocity"]).max() < 1e-6
    for name in ("yaw", "pitch", "roll"):
        assert np.abs(np.sin(found[name] - truth[name])).max() < 1e-9


def test_an_integrator_of_another_kind_ends_at_the_end_of_the_arm(folder: Path) -> None:
    """Runge–Kutta in the Earth frame, from the sensor's place and axes on, on the increments alone."""
    truth, found = table(folder, "truth"), table(folder, "found")
    mounting = Rotation.from_euler("ZYX", TURNED_DEG, degrees=True)
    turn = Rotation.from_matrix(_body_in_earth(truth[0])).inv() * Rotation.from_matrix(
        _body_in_earth(truth[1])
    )
    rate = turn.as_rotvec() * 200.0
    start = _sensor_state(truth[0], rate, mounting)
    force, turning = (_rates(found[name] * 200.0) for name in ("dv", "dtheta"))
    end = oracle.integrate(start, force, turning, 1.0 / 200)
    last = _body_in_earth(found[-1])
    place = _earth(found[-1]) + last @ np.array(ARM_M)
    assert np.linalg.norm(end[:3] - place) < 1e-3
    off = (Rotation.from_matrix(last) * mounting).inv() * Rotation.from_quat(end[6:], scalar_first=True)
    assert off.magnitude() < 1e-8


def _earth(row: Any) -> NDArray[np.float64]:
    return np.asarray(oracle.ecef(row["latitude"], row["longitude"], row["height"]))


def _body_in_earth(row: Any) -> NDArray[np.float64]:
    c_nb = Rotation.from_euler("ZYX", [row["yaw"], row["pitch"], row["roll"]]).as_matrix()
    turned: NDArray[np.float64] = oracle.rotation_ned_to_ecef(row["latitude"], row["longitude"]) @ c_nb
    return turned


def _sensor_state(row: Any, rate: NDArray[np.float64], mounting: Rotation) -> NDArray[np.float64]:
    """Position, velocity in the Earth frame, quaternion of the sensor's axes; `rate`: ω_eb in body axes."""
    c_eb = _body_in_earth(row)
    velocity = oracle.rotation_ned_to_ecef(row["latitude"], row["longitude"]) @ row["velocity"]
    velocity = velocity + c_eb @ np.cross(rate, ARM_M)
    quaternion = (Rotation.from_matrix(c_eb) * mounting).as_quat(scalar_first=True)
    return np.concatenate((_earth(row) + c_eb @ np.array(ARM_M), velocity, quaternion))


def _rates(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values at half steps of a function with these means over the steps, by a spline of the sums."""
    sums = np.vstack((np.zeros((1, 3)), np.cumsum(means, axis=0)))
    slope = make_interp_spline(np.arange(len(sums)), sums, k=5).derivative()
    return np.ascontiguousarray(slope(np.arange(2 * len(means) + 1) / 2))


def test_a_track_over_the_antimeridian_keeps_its_way_at_the_end_of_an_arm(tmp_path: Path) -> None:
    rows = [f"{t},10,{180 + 1e-3 * (t - 10) - (360 if t > 10 else 0):.9f},5" for t in range(21)]
    (tmp_path / "date-line.csv").write_text("t_s,lat,lon,alt\n" + "\n".join(rows) + "\n")
    words = ("--imu-at", "5,0,0", "--gnss-rate", 1, "-o", tmp_path / "i.npz", "--json", "-", "-q")
    result = navtwin("inverse", tmp_path / "date-line.csv", *words)
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["closure"]["position_max_m"] < 1e-4
    assert told["fastest_mps"] == pytest.approx(
        math.radians(1e-3) * 6.379e6 * math.cos(math.radians(10.0)), rel=0.01
    )
    made = np.load(tmp_path / "i.npz")
    east = np.degrees(made["imu"]["longitude"])
    assert np.abs(east).max() <= 180.0
    assert ((east > 0).mean(), (east < 0).mean()) == (
        pytest.approx(0.5, abs=0.01),
        pytest.approx(0.5, abs=0.01),
    )
    assert -180.0 <= made["gnss"]["longitude_deg"].min() < -179.98


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--imu-at", "1,2"), "--imu-at 1,2: must be three lengths"),
        (("--imu-at", "0,0,101"), "each must lie within ±100 m"),
        (("--mounting", "0,91,0"), "within ±360, 90, 180"),
    ],
)
def test_mistakes_are_one_message(folder: Path, more: tuple[str, ...], words: str) -> None:
    result = navtwin("inverse", folder / "truth.npz", *more)
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
