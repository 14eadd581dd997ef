"""KF-GINS text and CSV by a mapping: columns, units, axes, clocks, and the drive that a board makes of it."""

import json

import numpy as np
import pytest
from circle_drive import GRAVITY, HEIGHT, RADIUS, SPEED, START_SOW, WEEK, at_rate, write_kf_gins
from imports import imported, kinds, navtwin, refused, rows

UNIX = 315_964_800 - 18 + WEEK * 604_800 + START_SOW
BEGINS = "2024-02-06T03:59:42Z"
NO_LEVER = ("--set", "board.chips.U3.lever_arm_m=[0.0,0.0,0.0]")


def replayed(capture, *options):
    outcome = navtwin(
        "replay", capture, "--board", "car_mems", "--mode", "physical", "-q", "--json", "-", *options
    )
    assert outcome.exit_code == 0, outcome.output
    return json.loads(outcome.stdout)


@pytest.fixture(scope="module")
def kf_gins(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kf")
    files = write_kf_gins(folder)
    return files, *imported(folder, "kf-gins", *files)


def test_increments_become_rates_and_forces(kf_gins):
    _, report, capture = kf_gins
    assert report["begins"] == BEGINS
    assert report["findings"] == []
    samples = rows(capture, "/imu/imu")
    assert len(samples) == 9000
    assert samples[0]["t_s"] == pytest.approx(0.005)  # the middle of its increment
    mean = {
        name: np.mean([row[name] for row in samples]) for name in samples[0] if name != "temperature_degc"
    }
    assert mean["rate_z_dps"] == pytest.approx(np.degrees(SPEED / RADIUS), rel=1e-3)
    assert mean["force_y_mps2"] == pytest.approx(SPEED**2 / RADIUS, rel=1e-3)
    assert mean["force_z_mps2"] == pytest.approx(-GRAVITY, rel=1e-4)
    assert rows(capture, "/gnss")[1]["h_acc_m"] == pytest.approx(np.hypot(0.5, 0.6), abs=1e-4)
    assert rows(capture, "/truth")[10]["yaw_deg"] == pytest.approx(np.degrees(SPEED / RADIUS), abs=1e-5)


def test_a_board_drives_on_it_against_its_reference(kf_gins):
    _, _, capture = kf_gins
    result = replayed(capture, *NO_LEVER)
    assert result["scored_against"] == "truth"
    assert result["metrics"]["position_horizontal_rms_m"] < 0.5
    assert result["metrics"]["yaw_rms_deg"] < 0.5
    assert result["metrics"]["roll_rms_deg"] < 0.3


def test_without_a_reference_the_week_is_asked_for(tmp_path, kf_gins):
    (imu, gnss, _), _, _ = kf_gins
    report, _ = imported(tmp_path, "kf-gins", imu, gnss)
    assert ("no time", "") in kinds(report)
    report, capture = imported(tmp_path, "kf-gins", gnss, imu, name="b.mcap", options=["--week", WEEK])
    assert report["begins"] == BEGINS
    result = replayed(capture, *NO_LEVER)
    assert result["scored_against"].startswith("recorded receiver")
    assert result["metrics"]["position_horizontal_rms_m"] < 0.5


def test_a_week_of_0_in_the_reference_says_nothing(tmp_path, kf_gins):
    (imu, gnss, truth), report, _ = kf_gins
    table = np.loadtxt(truth)
    table[:, 0] = 0
    np.savetxt(tmp_path / "own.nav", table, "%.9f")
    again, _ = imported(tmp_path, "kf-gins", imu, gnss, tmp_path / "own.nav", options=["--week", WEEK])
    assert again["begins"] == BEGINS
    assert again["topics"] == report["topics"]
    again, _ = imported(tmp_path, "kf-gins", imu, gnss, tmp_path / "own.nav", name="b.mcap")
    assert ("no time", "") in kinds(again)
    assert again["topics"] == report["topics"]


def test_parts_are_told_or_stated(tmp_path, kf_gins):
    (imu, gnss, truth), report, _ = kf_gins
    again, _ = imported(tmp_path, "kf-gins", f"truth={truth}", f"gnss={gnss}", f"imu={imu}")
    assert again["topics"] == report["topics"]
    assert "two files are taken for imu" in refused(tmp_path, "kf-gins", imu, imu)
    (tmp_path / "x.txt").write_text("1 2 3\n4 5 6\n")
    assert "rows have 3 columns" in refused(tmp_path, "kf-gins", tmp_path / "x.txt")
    report, _ = imported(tmp_path, "kf-gins", imu, name="imu.mcap", options=["--week", WEEK])
    assert "no physical replay: there is no receiver in it" in report["uses"]


def test_seconds_of_week_go_on_behind_its_end(tmp_path):
    t = np.arange(600.0) * 0.01
    sow = (604_797.0 + t) % 604_800.0
    table = np.column_stack((sow, np.random.default_rng(1).standard_normal((600, 6)) * 1e-4))
    table[:, 6] -= 0.098
    np.savetxt(tmp_path / "imu.txt", table, "%.9f")
    report, capture = imported(tmp_path, "kf-gins", tmp_path / "imu.txt", options=["--week", 2300])
    times = [row["t_s"] for row in rows(capture, "/imu/imu")]
    assert np.diff(times) == pytest.approx(0.01)
    assert len(times) == 600
    assert kinds(report) == {}


IMU_MAP = """
[imu]
file = "imu.csv"
time = { column = "time_ms", unit = "ms", base = "unix" }
gyro = { columns = ["gx", "gy", "gz"], unit = "deg/s" }
accel = { columns = ["ax", "ay", "az"], unit = "g" }
temperature = "warm"
axes = ["x", "-y", "-z"]
"""
GNSS_MAP = """
[gnss]
file = "gnss.csv"
time = { column = "utc", unit = "iso8601", base = "unix" }
position = { columns = ["lat", "lon"] }
height = { column = 4, above = "sea", geoid_separation_m = 47.5 }
velocity = { speed = "speed", course = "course", unit = "km/h" }
"""


def write_csv(folder, duration_s=90.0, mapping=IMU_MAP + GNSS_MAP):
    from datetime import UTC, datetime

    drive, slow = at_rate(100.0, duration_s), at_rate(5.0, duration_s)
    up = np.array([1, -1, -1])
    table = np.column_stack(
        ((UNIX + drive.t) * 1000, np.degrees(drive.rate) * up, drive.force / 9.80665 * up)
    )
    lines = [",".join(f"{value:.6f}" for value in row) + ",25.5" for row in table]
    (folder / "imu.csv").write_text("time_ms,gx,gy,gz,ax,ay,az,warm\n" + "\n".join(lines) + "\n")
    lines = ['"utc";lat;lon;h;speed;course']
    for t, place, yaw in zip(slow.t, slow.place, slow.yaw, strict=True):
        moment = datetime.fromtimestamp(UNIX + t, UTC).isoformat().replace("+00:00", "Z")
        motion = f"{SPEED * 3.6:.3f};{np.degrees(yaw) % 360:.4f}"
        lines.append(f'"{moment}";{place[0]:.9f};{place[1]:.9f};{HEIGHT - 47.5:.3f};{motion}')
    (folder / "gnss.csv").write_text("\n".join(lines) + "\n")
    (folder / "map.toml").write_text(mapping)
    return folder / "imu.csv", folder / "gnss.csv"


def test_csv_files_of_two_clocks_become_one_drive(tmp_path):
    imu, gnss = write_csv(tmp_path)
    report, capture = imported(tmp_path, "csv", imu, gnss, options=["--map", tmp_path / "map.toml"])
    assert report["begins"] == BEGINS
    assert report["findings"] == []
    samples = rows(capture, "/imu/imu")
    mean = {name: np.mean([row[name] for row in samples]) for name in samples[0]}
    assert mean["rate_z_dps"] == pytest.approx(np.degrees(SPEED / RADIUS), rel=1e-3)
    assert mean["force_z_mps2"] == pytest.approx(-GRAVITY, rel=1e-4)
    assert mean["temperature_degc"] == 25.5
    assert samples[1]["t_s"] - samples[0]["t_s"] == pytest.approx(0.01, abs=1e-6)
    epochs = rows(capture, "/gnss")
    assert epochs[5]["t_s"] == pytest.approx(1.0, abs=1e-6)
    assert epochs[5]["height_m"] == HEIGHT
    assert epochs[5]["v_north_mps"] == pytest.approx(SPEED * np.cos(SPEED / RADIUS), abs=1e-3)
    result = replayed(capture, *NO_LEVER)
    assert result["metrics"]["position_horizontal_rms_m"] < 0.5
    assert result["metrics"]["yaw_rms_deg"] < 1.0


@pytest.mark.parametrize(
    ("old", "new", "better"),
    [
        ('unit = "deg/s"', 'unit = "rad/s"', "gyro=deg/s"),
        ('unit = "g"', 'unit = "m/s2"', "accel=g"),
        ('unit = "km/h"', 'unit = "m/s"', "velocity=km/h"),
    ],
)
def test_wrong_units_are_refused_until_the_right_one_is_stated(tmp_path, old, new, better):
    files = write_csv(tmp_path, 60.0, (IMU_MAP + GNSS_MAP).replace(old, new))
    options = ["--map", tmp_path / "map.toml"]
    assert f"state the right one with --unit {better}" in refused(tmp_path, "csv", *files, options=options)
    report, _ = imported(tmp_path, "csv", *files, options=[*options, "--unit", better])
    assert report["findings"] == []
    quantity, named = better.partition("=")[0], new.split('"')[1]
    report, _ = imported(
        tmp_path, "csv", *files, name="b.mcap", options=[*options, "--unit", f"{quantity}={named}"]
    )
    assert any(kind == "doubtful unit" for kind, _ in kinds(report))


def test_an_axis_upwards_is_told(tmp_path):
    files = write_csv(tmp_path, 60.0, (IMU_MAP + GNSS_MAP).replace('"-z"', '"z"'))
    report, _ = imported(tmp_path, "csv", *files, options=["--map", tmp_path / "map.toml"])
    (finding,) = report["findings"]
    assert finding["channel"] == "/imu/imu axes"
    assert "its z axis points up" in finding["examples"][0]["value"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"gx"', '"gyrox"', "names the column 'gyrox', which the header does not have; known: ax, ay"),
        ('"deg/s"', '"degrees"', "is no unit of gyro; known: deg/s, rad/s, mdeg/s"),
        ('unit = "ms"', 'unit = "minutes"', "time.unit"),
        ("time = {", "tmie = {", "tmie"),
        ("[imu]", "[imo]", "imo"),
        ('axes = ["x", "-y", "-z"]', 'axes = ["x", "x", "-z"]', "axes must name x, y and z once each"),
        (', base = "unix" }\ngyro', ', base = "recording" }\ngyro', "clocks of a recording's own and of GPS"),
        (', base = "unix" }\ngyro', ', base = "week" }\ngyro', 'needs week = 2300 or week_column = "week"'),
        (", geoid_separation_m = 47.5", "", 'above = "sea" needs geoid_separation_m'),
        (
            'file = "imu.csv"',
            'file = "other.csv"',
            "file = 'other.csv' in [imu] is none of imu.csv, gnss.csv",
        ),
        ("[imu]", "[imu", "not valid TOML"),
    ],
)
def test_a_wrong_mapping_is_told_in_one_message(tmp_path, old, new, message):
    mapping = (IMU_MAP + GNSS_MAP).replace(old, new, 1)
    assert mapping != IMU_MAP + GNSS_MAP
    files = write_csv(tmp_path, 2.0, mapping)
    told = refused(tmp_path, "csv", *files, options=["--map", tmp_path / "map.toml"])
    assert message in " ".join(told.split())


def test_without_a_mapping_an_example_is_shown(tmp_path):
    files = write_csv(tmp_path, 2.0)
    told = refused(tmp_path, "csv", *files)
    assert "needs a mapping file, --map mapping.toml" in told
    assert 'gyro = { columns = ["gx", "gy", "gz"], unit = "deg/s" }' in told


def test_lines_and_values_that_are_no_rows_are_told(tmp_path):
    imu, _ = write_csv(tmp_path, 30.0)
    lines = imu.read_text().splitlines()
    lines[100] = "garbage"
    lines[200] = lines[200].replace(",", ";", 3)
    lines[300] = ",".join(["nan", *lines[300].split(",")[1:]])
    parts = lines[400].split(",")
    lines[400] = ",".join([*parts[:2], "", *parts[3:]])
    lines[500] = lines[499]
    lines[-1] = lines[-1][:30]
    imu.write_text("\n".join(lines))
    (tmp_path / "map.toml").write_text(IMU_MAP)
    report, capture = imported(tmp_path, "csv", imu, options=["--map", tmp_path / "map.toml"])
    found = {one["kind"]: one for one in report["findings"]}
    assert [one["place"] for one in found["unreadable"]["examples"]] == ["line 101", "line 201", "line 3001"]
    assert found["duplicate"]["examples"][0]["place"] == "line 501"
    assert found["gap"]["count"] == 5
    assert {
        (f["channel"], f["examples"][0]["place"])
        for f in report["findings"]
        if f["kind"] == "not a finite number"
    } == {
        ("time", "line 301"),
        ("/imu/imu rate_y_dps", "line 401"),
    }
    assert len(rows(capture, "/imu/imu")) == 3000 - 6
    assert json.loads(json.dumps(report))["left_out"] == 2
