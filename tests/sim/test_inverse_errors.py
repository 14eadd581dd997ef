"""`navtwin inverse` with errors of sensors and a receiver along the way."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from host.cli.main import app

PER_ROOT_HOUR = 60.0


def inverse(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["inverse", *[str(one) for one in arguments]])


@pytest.fixture(scope="module")
def standing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten minutes at rest, a point a second."""
    path = tmp_path_factory.mktemp("inverse") / "rest.csv"
    rows = [f"{t},47.0,8.0,440,0,0,0,30,0,0" for t in range(601)]
    header = "t_s,lat,lon,alt,v_north_mps,v_east_mps,v_down_mps,heading,pitch_deg,roll_deg"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_noise_of_the_preset_lies_on_the_increments(standing: Path, tmp_path: Path) -> None:
    options = ("--rate", 100, "-p", "stim300", "--set", "imu.accelerometer.bias_mg=[10.0, 0.0, 0.0]")
    clean, noisy = tmp_path / "clean.npz", tmp_path / "noisy.npz"
    assert inverse(standing, "--rate", 100, "-o", clean).exit_code == 0
    told = inverse(standing, *options, "-o", noisy, "--json", "-", "-q")
    assert told.exit_code == 0, told.output
    assert json.loads(told.stdout)["closure"]["position_rms_m"] < 1e-5  # of the increments without errors
    one, other = np.load(clean)["imu"], np.load(noisy)["imu"]
    for name in ("t_ns", "latitude", "velocity", "yaw"):
        assert (one[name] == other[name]).all()
    turned, pushed = other["dtheta"] - one["dtheta"], other["dv"] - one["dv"]
    arw, vrw = math.radians(0.15) / PER_ROOT_HOUR, 0.07 / PER_ROOT_HOUR
    assert np.diff(turned, axis=0).std(axis=0) / math.sqrt(2.0) == pytest.approx([arw * 0.1] * 3, rel=0.02)
    assert np.diff(pushed, axis=0).std(axis=0) / math.sqrt(2.0) == pytest.approx([vrw * 0.1] * 3, rel=0.02)
    assert pushed[:, 0].mean() * 100 == pytest.approx(10e-3 * 9.80665, abs=2e-3)
    again = tmp_path / "again.npz"
    assert inverse(standing, *options, "-o", again, "--seed", 2).exit_code == 0
    assert (np.load(again)["imu"]["dv"] != other["dv"]).all()


def test_a_receiver_comes_along(standing: Path, tmp_path: Path) -> None:
    errors = ["gnss.position_white_m=0.3", "gnss.position_markov_m=0.0", "gnss.velocity_white_mps=0.02"]
    options = [word for error in errors for word in ("--set", error)]
    cut = ("--set", "outage=[{start_s=100.0,duration_s=50.0}]", "--set", "gnss.reacquisition_s=0.0")
    out = tmp_path / "out.npz"
    assert inverse(standing, "--gnss-rate", 5, *options, *cut, "-o", out).exit_code == 0
    gnss = np.load(out)["gnss"]
    assert len(gnss) == 3001
    assert (gnss["fix"] == 0).sum() == 250
    fixed = gnss[gnss["fix"] == 1]
    north = np.radians(fixed["latitude_deg"] - 47.0) * 6.37e6
    assert north.std() == pytest.approx(0.3, rel=0.06)
    assert fixed["v_east_mps"].std() == pytest.approx(0.02, rel=0.06)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("-p", "stim30"), "did you mean 'stim300'"),
        (("--set", "vibration.x_mps2=1.0"), "not about a sensor's errors"),
        (("--set", "imu.gyro.foo=1"), "unknown key imu.gyro.foo"),
        (("--set", "gnss.position_white_m=nan"), "must be a finite number"),
        (("--gnss-rate", "fast"), "--gnss-rate fast"),
        (("--seed", "-1"), "--seed -1"),
    ],
)
def test_mistakes_are_one_message(
    standing: Path, tmp_path: Path, options: tuple[str, ...], words: str
) -> None:
    result = inverse(standing, *options, "-o", tmp_path / "x.csv")
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_part_of_an_attitude_is_not_dropped_in_silence(tmp_path: Path) -> None:
    """A heading alone is told to be of no use; with pitch and roll it is taken."""
    path = tmp_path / "heading.csv"
    lines = [f"{k},{47 + k * 1e-4},8.0,440,33" for k in range(8)]
    path.write_text("t_s,lat,lon,alt,heading\n" + "\n".join(lines) + "\n")
    result = CliRunner().invoke(app, ["inverse", str(path)])
    assert result.exit_code == 0, result.output
    assert "not used: yaw;" in result.output
    path.write_text(
        "t_s,lat,lon,alt,heading,pitch,roll\n" + "\n".join(f"{line},0,0" for line in lines) + "\n"
    )
    result = CliRunner().invoke(app, ["inverse", str(path)])
    assert "not used" not in result.output
    assert "attitude from the file" in result.output


def test_an_antenna_off_the_sensor_is_elsewhere_and_swings(tmp_path: Path) -> None:
    """Eastwards at 10 m/s on the equator, turning at 0.2 rad/s: 3 m ahead is 3 m along yaw, 0.6 m/s faster
    across it."""
    lines = [
        f"{0.1 * k:.1f},0,{math.degrees(k / 6378137.0):.12f},0,{math.degrees(0.02 * k):.9f},0,0"
        for k in range(101)
    ]
    path = tmp_path / "spin.csv"
    path.write_text("t_s,lat,lon,alt,yaw,pitch,roll\n" + "\n".join(lines) + "\n")
    zero = ("position_white_m", "position_markov_m", "velocity_white_mps")
    quiet = ["--gnss-rate", "1", *(word for name in zero for word in ("--set", f"gnss.{name}=0"))]
    found = []
    for antenna in ("3,0,0", "0,0,0"):
        result = inverse(path, "-o", tmp_path / "spin.npz", *quiet, "--antenna", antenna)
        assert result.exit_code == 0, result.output
        found.append(np.load(tmp_path / "spin.npz")["gnss"])
    there, here = found
    yaw = 0.2 * here["t_s"]
    east = np.radians(there["longitude_deg"] - here["longitude_deg"]) * 6378137.0
    north = np.radians(there["latitude_deg"] - here["latitude_deg"]) * 6335439.3
    np.testing.assert_allclose(east, 3.0 * np.sin(yaw), atol=2e-3)
    np.testing.assert_allclose(north, 3.0 * np.cos(yaw), atol=2e-3)
    inside = slice(1, -1)  # the spline ends without a neighbour
    np.testing.assert_allclose(
        (there["v_north_mps"] - here["v_north_mps"])[inside], -0.6 * np.sin(yaw)[inside], atol=2e-3
    )
    np.testing.assert_allclose(
        (there["v_east_mps"] - here["v_east_mps"])[inside], 0.6 * np.cos(yaw)[inside], atol=2e-3
    )


def test_a_loop_goes_through_the_vertical(tmp_path: Path) -> None:
    """Ten attitudes a second of a body that pitches over at 20 °/s: yaw and roll jump at each vertical,
    the body does not. Besides its turn it feels the Earth's, 0.0042 °/s at most."""
    lines = []
    for k in range(201):
        over = math.radians(2.0 * k)
        pitch, front = math.degrees(math.asin(math.sin(over))), math.cos(over) >= 0.0
        lines.append(f"{k / 10:.1f},47,8,5000,{0 if front else 180},{pitch:.12g},{0 if front else 180}")
    path = tmp_path / "loop.csv"
    path.write_text("t_s,lat,lon,alt,yaw,pitch,roll\n" + "\n".join(lines) + "\n")
    result = inverse(path, "-o", tmp_path / "loop.npz", "-q")
    assert result.exit_code == 0, result.output
    rate = np.degrees(np.load(tmp_path / "loop.npz")["imu"]["dtheta"] * 200.0)
    assert np.abs(rate - [0.0, 20.0, 0.0]).max() < 0.0043
