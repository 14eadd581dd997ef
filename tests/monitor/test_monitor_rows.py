"""Decoded and imported topics: shown by their times, whatever they hold."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from monitor_command import last_line, monitor
from rich.console import Console
from spoken_drive import manifest, place
from spoken_receiver import sentences
from typer.testing import CliRunner

from host.capture.writer import CaptureWriter
from host.cli.main import app
from host.monitor.capture_rows import SHOWN, Rows
from host.monitor.capture_source import CaptureSource
from host.monitor.figures import figures_line
from host.monitor.health_panels import imu_lines
from host.monitor.motion_panels import attitude_lines
from host.monitor.view import MonitorView
from host.record.tables import BIAS, GNSS, INNOVATION, SOLUTION


def row(table, **values) -> np.ndarray:
    return np.array([[values.get(name, np.nan) for name in table.columns]])


@pytest.fixture
def decoded_capture(tmp_path):
    """JSON topics alone, each topic in one batch, so that times in the file go back three times."""
    writer = CaptureWriter(tmp_path / "decoded.mcap", manifest())
    for t in range(12):
        lat, lon, yaw = (value / scale for value, scale in zip(place(t), (1e9, 1e9, 1), strict=True))
        motion = {"latitude_deg": lat, "longitude_deg": lon, "height_m": 500.0 + t}
        angles = {"yaw_deg": np.degrees(yaw), "pitch_deg": 1.5, "roll_deg": -2.5, "mode": 3, "flags": 256}
        speeds = {"v_north_mps": 3.0, "v_east_mps": 4.0, "v_down_mps": 0.5}
        sigmas = {"sigma_north_m": 0.5, "sigma_psi_d_deg": 0.75}
        writer.rows("/solution", row(SOLUTION, t_s=t, **motion, **angles, **speeds, **sigmas))
    for t in range(12):
        lat, lon, _ = place(t)
        writer.rows("/gnss", row(GNSS, t_s=t, fix=t < 8, latitude_deg=lat / 1e9, longitude_deg=lon / 1e9))
    innovation = {"north_m": 1.25, "sigma_north_m": 2.5, "used": 63}
    writer.rows("/innovation", row(INNOVATION, t_s=6, **innovation))
    writer.rows("/bias", row(BIAS, t_s=6, gyro_x_dps=0.25, mounting_yaw_deg=1.5, latency_s=0.08))
    writer.event(5_500_000_000, "mcu", "something happened")
    writer.close({"state_hash": "0" * 64, "duration_s": "11.0"})
    return tmp_path / "decoded.mcap"


def test_decoded_topics_alone_are_shown_too(decoded_capture):
    shown = last_line(str(decoded_capture), "--once")
    lat, lon, yaw = place(11)
    assert shown["solution"]["latitude_deg"] == pytest.approx(lat * 1e-9, abs=1e-9)
    assert shown["solution"]["longitude_deg"] == pytest.approx(lon * 1e-9, abs=1e-9)
    assert shown["solution"]["yaw_deg"] == pytest.approx(np.degrees(yaw), abs=1e-3)
    assert shown["solution"]["roll_deg"] == pytest.approx(-2.5)
    assert shown["solution"]["sigma_yaw_deg"] == pytest.approx(0.75)
    assert shown["solution"]["flag_names"] == ["standstill"]
    assert shown["solution"]["utc_time_of_day_ms"] is None
    assert shown["gnss"]["fix"] == "no fix"
    assert shown["innovation"]["north_m"] == 1.25
    assert shown["bias"]["gyro_x_dps"] == pytest.approx(0.25)
    assert shown["bias"]["mounting_yaw_deg"] == pytest.approx(1.5)
    assert shown["track"]["gnss_points"] == 8
    assert [event["text"] for event in shown["events"]] == ["mcu: something happened"]
    assert shown["satellites"] is None
    # in the order of time: at 6 s the fix is still there, and the event has been told
    earlier = last_line(str(decoded_capture), "--once", "--seconds", "6.5")
    assert earlier["gnss"]["fix"] == "2D"
    assert earlier["solution"]["t_s"] == 6.0
    assert earlier["events"][0]["t_s"] == pytest.approx(5.5)


def test_an_imported_receiver_log(tmp_path):
    (tmp_path / "log.nmea").write_bytes(sentences(20))
    capture = str(tmp_path / "log.mcap")
    made = CliRunner().invoke(app, ["import", "nmea", str(tmp_path / "log.nmea"), "-o", capture, "-q"])
    assert made.exit_code == 0, made.output
    shown = last_line(capture, "--once")
    assert shown["solution"] is None
    assert shown["gnss"]["latitude_deg"] == pytest.approx(48.1 + 19 * 0.0027 / 60, abs=1e-8)
    assert shown["gnss"]["satellites_used"] == 5
    names = [(one["system"], one["number"], one["cn0_dbhz"]) for one in shown["satellites"]]
    assert names == [("GPS", 5, 47), ("GPS", 13, 41), ("GPS", 15, 33), ("GPS", 20, None)]
    assert shown["track"]["gnss_points"] == 20
    assert "receiver: 3D" in monitor(capture, "--once").stdout


def test_an_imported_drive_shows_all_of_one_time_together(tmp_path):
    """Topics stand in such a file minutes after one another."""
    imu = [f"{t / 50},0,0,{t / 50},0.25,0,-9.75" for t in range(50 * 120)]
    gnss = [f"{t / 5},48.1,11.5,500,{t / 5}" for t in range(5 * 120)]
    (tmp_path / "imu.csv").write_text("\n".join(["t,gx,gy,gz,ax,ay,az", *imu]))
    (tmp_path / "gnss.csv").write_text("\n".join(["t,lat,lon,h,hdop", *gnss]))
    (tmp_path / "map.toml").write_text(
        """
        [time]
        column = "t"
        [imu]
        file = "imu.csv"
        gyro = { columns = ["gx", "gy", "gz"], unit = "deg/s" }
        accel = { columns = ["ax", "ay", "az"], unit = "m/s2" }
        [gnss]
        file = "gnss.csv"
        position = { columns = ["lat", "lon"] }
        height = { column = "h" }
        hdop = "hdop"
        """
    )
    capture = str(tmp_path / "drive.mcap")
    files = [str(tmp_path / name) for name in ("imu.csv", "gnss.csv")]
    options = ["--map", str(tmp_path / "map.toml"), "-o", capture, "-q"]
    made = CliRunner().invoke(app, ["import", "csv", *files, *options])
    assert made.exit_code == 0, made.output
    source, view = CaptureSource(Path(capture), speed=0.0), MonitorView("drive")
    source.pump(view, 60.0, 0.0)  # the clock begins
    for now_s in (20.0, 70.0):
        source.pump(view, 60.0, now_s)
        assert source.now_s == pytest.approx(now_s)
        shown = imu_lines(view.state, 60, 20)[0].plain.split()
        assert float(shown[-1]) == pytest.approx(now_s, abs=0.1)
        assert view.state.gnss.hdop_centi == pytest.approx(now_s * 100, abs=20)
    source.close()


def test_gyro_and_accelerometer_recorded_by_turns(tmp_path):
    """Imported arrays hold inertial samples, an attitude and no position."""
    writer = Rows(has_solution=False)
    view = MonitorView("recording")
    rows = [
        ("/imu/gyro", 0, {"rate_x_dps": 1.0, "rate_y_dps": 2.0, "rate_z_dps": 3.0}),
        ("/imu/accel", 10, {"force_x_mps2": 0.5, "force_y_mps2": 0.25, "force_z_mps2": -9.75}),
        ("/imu/accel", 60, {"force_x_mps2": 7.0, "force_y_mps2": 7.0, "force_z_mps2": 7.0}),
        ("/attitude", 70, {"yaw_deg": 123.0, "pitch_deg": -4.0, "roll_deg": 5.0}),
    ]
    for topic, ms, row in rows:
        message = writer.message(topic, ms * 1_000_000, json.dumps(row).encode())
        view.take([message] if message else [], ms / 1000)
    text = "".join(line.plain + "\n" for line in imu_lines(view.state, 60, 20))
    assert text.splitlines()[0].split()[2:] == ["1.00", "2.00", "3.00"]
    assert text.splitlines()[1].split()[2:] == ["0.50", "0.25", "-9.75"]  # the one 50 ms later is left out
    assert "123.00°" in "".join(line.plain for line in attitude_lines(view.state, 40, 12))


JSON = some.recursive(
    some.none() | some.booleans() | some.integers() | some.floats() | some.text(max_size=5),
    lambda inner: some.lists(inner, max_size=3),
    max_leaves=3,
)
NAMES = (
    "latitude_deg",
    "longitude_deg",
    "height_m",
    "v_north_mps",
    "yaw_deg",
    "mode",
    "flags",
    "fix",
    "hdop",
)
MORE_NAMES = (
    "h_acc_m",
    "used",
    "number",
    "system",
    "cn0_dbhz",
    "elevation_deg",
    "text",
    "rate_x_dps",
    "gyro_x_dps",
)


@settings(max_examples=60, deadline=None)
@given(
    some.lists(
        some.tuples(
            some.sampled_from(["/imu/x", "/event", *SHOWN[:-1]]),
            some.dictionaries(some.sampled_from(NAMES + MORE_NAMES), JSON) | JSON,
        ),
        max_size=8,
    )
)
def test_any_row_can_be_shown(told):
    rows = Rows(has_solution=False)
    view = MonitorView("noise")
    for k, (topic, row) in enumerate(told):
        message = rows.message(topic, k * 10**9, json.dumps(row).encode())
        view.take([message] if message else [], float(k))
    Console(file=io.StringIO()).print(view.render(120, 40))
    json.loads(figures_line(view))
