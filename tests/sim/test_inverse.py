"""`navtwin inverse`: closed loops, independent integrators, every kind of file, what nobody can drive."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import ecef_mechanization as oracle
import numpy as np
import pytest
from drives import attitude_difference
from numpy.typing import NDArray
from pynmeagps import NMEAMessage
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner, Result

from host.cli.main import app
from host.sim.scenario.load import scenario_from
from host.sim.simulated import SimulatedVehicle

PLACE = {"latitude_deg": 30.0, "longitude_deg": 114.0, "height_m": 20.0}
SHAKEN = {"vibration": {"z_mps2": 1.5, "x_mps2": 0.5}, "sway": {"roll_deg": 0.4, "pitch_deg": 0.3}}
BASIC = [
    [1, 20],
    [3, 10, 12, 0],
    [7, 8, 0, 90],
    [4, 5, 1.0, 0],
    [10, 5, 0, 10],
    [5, 12, 1, 4],
    [9, 12, 6, 10],
    [3, 9, 0],
]
ODD = [[1, 3.3337], [4, 5.1213, 3.0], [8, 6.01717, 10, 0], [4, 3.3331, -3.0], [8, 4.4444, -12], [3, 5, 0]]
SMOOTH = [
    {"kind": "rest", "duration_s": 20.0},
    {"kind": "reach-speed", "duration_s": 10.0, "to_mps": 12.0},
    {"kind": "turn", "duration_s": 8.0, "angle_deg": 90.0},
    {"kind": "accelerate", "duration_s": 4.0, "acceleration_mps2": 1.0},
    {"kind": "turn-rate-ramp", "duration_s": 5.0, "from_dps": 0.0, "to_dps": 10.0},
    {"kind": "surge", "duration_s": 12.0, "amplitude_mps2": 1.0, "period_s": 4.0},
    {"kind": "acceleration-ramp", "duration_s": 4.0, "from_mps2": 0.0, "to_mps2": -1.0},
    {"kind": "weave", "duration_s": 12.0, "amplitude_dps": 10.0, "period_s": 6.0},
    {"kind": "weave-cosine", "duration_s": 6.0, "amplitude_dps": 5.0, "period_s": 6.0},
    {"kind": "circle", "duration_s": 10.0, "rate_dps": 6.0},
    {"kind": "speed-change", "duration_s": 5.0, "by_mps": -3.0},
    {"kind": "reach-speed", "duration_s": 9.0, "to_mps": 0.0},
]
CAR = [
    {"kind": "rest", "duration_s": 20.0},
    {"kind": "reach-speed", "duration_s": 8.0, "to_mps": 15.0},
    *[{"kind": "turn", "duration_s": 8.0, "angle_deg": a} for a in (90.0, -60.0)],
    {"kind": "cruise", "duration_s": 20.0, "pitch_to_deg": 3.0},
    {"kind": "reach-speed", "duration_s": 8.0, "to_mps": 0.0},
]
SCENES: dict[str, dict[str, Any]] = {
    "rest": {"segment": [{"kind": "rest", "duration_s": 120.0}]},
    "basic": {"segment": SMOOTH},
    "car": {"segment": CAR, **SHAKEN},
    "ship": {"segment": [{"kind": "ship", "duration_s": 120.0}], "initial": {"speed_mps": 6.0}},
    "aircraft": {"segment": [{"kind": "aircraft", "duration_s": 120.0, "speed_mps": 60.0}]},
    "shell": {"segment": [{"kind": "shell"}]},
}


def vehicle(scene: dict[str, Any]) -> SimulatedVehicle:
    return SimulatedVehicle(scenario_from({"place": PLACE, **scene}, "scene", "scene"), 1)


def inverse(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["inverse", *[str(one) for one in arguments]])


def figures(*arguments: object) -> dict[str, Any]:
    result = inverse(*arguments, "--json", "-", "-q")
    assert result.exit_code == 0, result.output
    told: dict[str, Any] = json.loads(result.stdout)
    return told


def truth_file(folder: Path, scene: dict[str, Any], rate_hz: int = 200) -> Path:
    """The truth of a scene as `navtwin simulate` writes it."""
    made = vehicle(scene)
    times = np.arange(0, made.duration_ns + 1, 1_000_000_000 // rate_hz)
    truth = made.truth(times)
    rows = np.column_stack(
        (
            *(
                times / 1e9,
                np.degrees(truth.latitude),
                np.degrees(truth.longitude),
                truth.height,
                truth.v_ned,
            ),
            *(np.degrees(truth.yaw), np.degrees(truth.pitch), np.degrees(truth.roll)),
        )
    )
    path = folder / "truth.csv"
    header = (
        "t_s,latitude_deg,longitude_deg,height_m,v_north_mps,v_east_mps,v_down_mps,yaw_deg,pitch_deg,roll_deg"
    )
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.15g")
    return path


@pytest.mark.parametrize("scene", SCENES)
def test_the_closed_loop_closes_within_the_stated_limits(tmp_path: Path, scene: str) -> None:
    told = figures(truth_file(tmp_path, SCENES[scene]))
    closure = told["closure"]
    assert closure["position_rms_m"] <= 1e-5
    assert closure["velocity_rms_mps"] <= 1e-6
    assert closure["attitude_rms_deg"] <= 1e-7
    assert told["attitude_from"] == "file"


@pytest.mark.parametrize("matrix", [BASIC, ODD])
def test_the_closed_loop_closes_where_the_numeric_form_steps(tmp_path: Path, matrix: list[Any]) -> None:
    """At joints between samples too."""
    closure = figures(truth_file(tmp_path, {"trajectory": {"matrix": matrix}}))["closure"]
    assert closure["position_rms_m"] <= 1e-5
    assert closure["velocity_rms_mps"] <= 1e-6
    assert closure["attitude_rms_deg"] <= 1e-7


@pytest.mark.parametrize("scene", ["car", "aircraft"])
def test_an_integrator_of_another_kind_comes_to_the_same_end(tmp_path: Path, scene: str) -> None:
    """Runge–Kutta in the Earth frame on rates that have these increments as their integrals."""
    file = truth_file(tmp_path, {key: value for key, value in SCENES[scene].items() if key == "segment"})
    assert inverse(file, "-o", tmp_path / "i.npz").exit_code == 0
    imu = np.load(tmp_path / "i.npz")["imu"]
    made = vehicle({"segment": SCENES[scene]["segment"]})
    row = made.motion.rows(np.array([0]))[0]
    state, _ = _earth_state(row)
    force, rate = (_rates(imu[name] * 200.0) for name in ("dv", "dtheta"))
    end = oracle.integrate(state, force, rate, 1.0 / 200)
    last = imu[-1]
    wanted, c_en = _earth_state(
        np.concatenate(
            (
                [last["latitude"], last["longitude"], last["height"], *last["velocity"]],
                Rotation.from_euler("ZYX", [last["yaw"], last["pitch"], last["roll"]]).as_matrix().ravel(),
            )
        )
    )
    assert np.abs(c_en.T @ (end[:3] - wanted[:3])).max() < 2e-3
    assert np.abs(end[3:6] - wanted[3:6]).max() < 5e-5
    assert attitude_difference(end[6:], wanted[6:]) < 1e-8


def _rates(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values at half steps of a function with these means over the steps, by a spline of the sums."""
    sums = np.vstack((np.zeros((1, 3)), np.cumsum(means, axis=0)))
    values: NDArray[np.float64] = make_interp_spline(np.arange(len(sums)), sums, k=5).derivative()(
        np.arange(2 * len(means) + 1) / 2
    )
    return np.ascontiguousarray(values)


def _earth_state(row: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    c_en = oracle.rotation_ned_to_ecef(row[0], row[1])
    quaternion = Rotation.from_matrix(c_en @ row[6:15].reshape(3, 3)).as_quat(scalar_first=True)
    return np.concatenate((oracle.ecef(*row[:3]), c_en @ row[3:6], quaternion)), c_en


def test_rates_and_files_of_other_kinds(tmp_path: Path) -> None:
    file = truth_file(tmp_path, {"segment": CAR}, 50)
    told = figures(file, "--rate", "819.2", "--samples", "mean", "-o", tmp_path / "i.npz")
    assert told["closure"]["position_rms_m"] < 1e-5
    imu = np.load(tmp_path / "i.npz")["imu"]
    made = vehicle({"segment": CAR})
    middle = made.motion.rows(imu["t_ns"][9000:9003] - 610_352)
    np.testing.assert_allclose(imu["rate"][9000:9003], middle[:, 15:18], atol=2e-6)
    np.testing.assert_allclose(imu["force"][9000:9003], middle[:, 18:21], atol=2e-3)
    again = figures(tmp_path / "i.npz", "-o", tmp_path / "j.mcap")
    assert again["closure"]["position_rms_m"] < 1e-5
    once_more = figures(tmp_path / "j.mcap")
    assert once_more["points"] == again["samples"]


# -- tracks of receivers: once a second, noisy, no attitude --------------------------------------


def receiver_points(
    seconds: int = 80, noise_m: float = 0.8
) -> tuple[SimulatedVehicle, Any, NDArray[np.float64]]:
    """The drive CAR once a second; latitude °, longitude °, height with noise."""
    made = vehicle({"segment": CAR})
    truth = made.truth(np.arange(seconds) * 1_000_000_000)
    random = np.random.default_rng(5)
    noise = noise_m * random.standard_normal((seconds, 3))
    points = np.column_stack((np.degrees(truth.latitude), np.degrees(truth.longitude), truth.height))
    points += noise / [111_000.0, 96_000.0, 1.0]
    return made, truth, points


def write_gpx(path: Path, points: NDArray[np.float64]) -> Path:
    body = "".join(
        f'<trkpt lat="{lat:.9f}" lon="{lon:.9f}"><ele>{h:.3f}</ele>'
        f"<time>2024-05-14T08:{k // 60:02d}:{k % 60:02d}Z</time></trkpt>\n"
        for k, (lat, lon, h) in enumerate(points.tolist())
    )
    path.write_text(
        f'<gpx xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>\n{body}</trkseg></trk></gpx>'
    )
    return path


def write_kml(path: Path, points: NDArray[np.float64]) -> Path:
    whens = "".join(f"<when>2024-05-14T08:{k // 60:02d}:{k % 60:02d}Z</when>" for k in range(len(points)))
    coords = "".join(f"<gx:coord>{lon:.9f} {lat:.9f} {h:.3f}</gx:coord>" for lat, lon, h in points.tolist())
    path.write_text(
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">'
        f"<Placemark><gx:Track>{whens}{coords}</gx:Track></Placemark></kml>"
    )
    return path


def write_nmea(path: Path, points: NDArray[np.float64]) -> Path:
    text = []
    for k, (lat, lon, h) in enumerate(points.tolist()):
        clock = f"08:{k // 60:02d}:{k % 60:02d}"
        fields = {
            "time": clock,
            "lat": lat,
            "lon": lon,
            "quality": 1,
            "numSV": 9,
            "HDOP": 0.9,
            "alt": h - 40.0,
        }
        text.append(
            NMEAMessage(
                "GN", "GGA", 0, **fields, altUnit="M", sep=40.0, sepUnit="M", hpnmeamode=1
            ).serialize()
        )
    path.write_bytes(b"".join(text))
    return path


WRITERS = {"gpx": write_gpx, "kml": write_kml, "nmea": write_nmea}


@pytest.mark.parametrize("kind", WRITERS)
def test_a_receivers_track_becomes_motion_that_can_be_driven(tmp_path: Path, kind: str) -> None:
    _made, truth, points = receiver_points()
    file = WRITERS[kind](tmp_path / f"drive.{kind}", points)
    told = figures(file, "-o", tmp_path / "i.npz")
    assert (told["points"], told["smooth_m"], told["attitude_from"]) == (80, 1.0, "motion")
    assert told["closure"]["position_rms_m"] < 1e-5
    assert told["strongest_mps2"] < 15.0
    assert told["fastest_mps"] < 17.5
    imu = np.load(tmp_path / "i.npz")["imu"]
    at = np.arange(1, 70) * 200 - 1
    north = (imu["latitude"][at] - truth.latitude[1:70]) * 6.36e6
    east = (imu["longitude"][at] - truth.longitude[1:70]) * 6.37e6 * math.cos(math.radians(30.0))
    assert np.hypot(north, east).max() < 4.0
    driving = slice(30, 60)
    turned = np.degrees(np.angle(np.exp(1j * (imu["yaw"][at] - truth.yaw[1:70]))))[driving]
    assert np.abs(turned).max() < 25.0
    assert np.abs(imu["roll"]).max() < 1e-12


def test_points_without_noise_are_met_exactly_and_a_bank_leans(tmp_path: Path) -> None:
    _, _, points = receiver_points(noise_m=0.0)
    file = write_gpx(tmp_path / "drive.gpx", points)
    told = figures(file, "--smooth", 0, "--bank", "-o", tmp_path / "i.npz")
    assert told["points_max_m"] < 1e-6
    imu = np.load(tmp_path / "i.npz")["imu"]
    right = imu["roll"][(33 * 200)]
    assert math.degrees(right) == pytest.approx(
        math.degrees(math.atan(15.0 * math.radians(90 / 6) / 9.81)), rel=0.25
    )


def test_a_line_of_kml_needs_a_speed(tmp_path: Path) -> None:
    path = tmp_path / "line.kml"
    places = " ".join(f"{8.3 + 1e-4 * k:.6f},47.05,440" for k in range(50))
    path.write_text(f"<kml><LineString><coordinates>{places}</coordinates></LineString></kml>")
    result = inverse(path)
    assert result.exit_code == 2
    assert "--speed 10" in result.stderr
    told = figures(path, "--speed", 10, "--smooth", "0.1")
    assert told["fastest_mps"] == pytest.approx(10.0, rel=0.02)
    assert told["duration_s"] == pytest.approx(
        49e-4 * math.cos(math.radians(47.05)) * 111_319.5 / 10.0, rel=3e-3
    )


HEAD = "t_s,lat,lon,alt\n"
GOOD = [f"{k},47.0{k},8.0,440" for k in range(8)]


def changed(number: int, line: str) -> str:
    lines = GOOD.copy()
    lines[number] = line
    return HEAD + "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1: no column of time"),
        ("a,b\n1,2\n", "line 1: no column of time"),
        (HEAD, "holds 0 points"),
        (changed(3, "2,47.03,8.0,440"), "line 5: time 2 s is that of the point before"),
        (changed(3, "1.5,47.03,8.0,440"), "line 5: time goes back from 2 s to 1.5 s"),
        (changed(3, "3,nan,8.0,440"), "line 5: the latitude is nan, no finite number; for example 47.05°"),
        (changed(3, "3,47.03,8.0"), "line 5: 3 values, the header has 4"),
        (changed(3, "3,47.03,8.0,up"), "line 5: height 'up' is not a number"),
        (changed(3, "3,97.03,8.0,440"), "line 5: latitude 97.03°"),
        (changed(3, "3,47.03,8.0,4e6"), "line 5: height 4e+06 m"),
        (changed(3, "3,46.0,8.0,440"), "m/s from the point before"),
        (changed(7, "99,47.07,8.0,440"), "line 9: 93 s after the point before"),
        ("t_s,lat,lon,height_ft\n0,47,8,1\n", "line 1: column height_ft: ft is no unit known here"),
        ("t_s,lat,lat,lon,alt\n0,47,47,8,1\n", "line 1: column lat is there twice"),
        (HEAD + "2024-05-14T08:00:00Z,47,8,1\n5,47,8,1\n", "line 3: time '5' is not ISO 8601"),
    ],
)
def test_what_nobody_can_have_driven_is_one_message(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "track.csv"
    file.write_text(text)
    result = inverse(file, "-o", tmp_path / "out.csv")
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert str(file) in result.stderr
    assert result.stderr.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["track.csv"]


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("x.gpx", b"<gpx><trk>", "not valid XML"),
        ("x.gpx", b"<gpx></gpx>", "no track points"),
        ("x.gpx", b'<gpx><trkpt lat="a" lon="2"/></gpx>', "point 1: lat 'a'"),
        ("x.gpx", b'<gpx><trkpt lat="1" lon="2"/></gpx>', "time None is not ISO 8601"),
        ("x.kml", b"<kml></kml>", "neither a gx:Track"),
        ("x.nmea", b"\xff\xfe$GPGGA,1\n", "no GGA sentence"),
        ("x.npz", b"PK", "is not what navtwin simulate writes"),
        ("x.mcap", b"\x89MCAP0\r\n", "is not a whole capture"),
        ("x.csv", b"t_s,lat,lon,alt\n\xff\xfe\n", "is not text"),
        ("x.doc", b"", "no known kind"),
    ],
)
def test_files_that_are_no_trajectories(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(content)
    result = inverse(tmp_path / name, "-o", tmp_path / "out.csv")
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--smooth", "-1"), "--smooth -1: must lie in"),
        (("--max-gap", "x"), "--max-gap x"),
        (("--samples", "instant"), "between two"),
        (("--rate", "0.1"), "less than two intervals"),
        (("-o", "x.doc"), "ending tells no format"),
        (("--speed", "0"), "--speed 0"),
    ],
)
def test_options_that_cannot_be(tmp_path: Path, more: tuple[str, ...], words: str) -> None:
    (tmp_path / "t.csv").write_text(HEAD + "\n".join(GOOD))
    result = inverse(tmp_path / "t.csv", *more)
    assert result.exit_code == 2, result.output
    assert words in result.stderr
