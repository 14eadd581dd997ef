"""Captures and boards: played in order and at their pace, jumped in, cut off; words that mean nothing."""

import io
import json
import os
import pty
import select
import signal
import struct
import sys
import termios
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from rich.console import Console
from spoken_drive import manifest, place, solution, spoken, write_capture
from spoken_receiver import sentences
from typer.testing import CliRunner

from firmware.link.frames import STATUS, FrameWriter
from host.capture.writer import CaptureWriter
from host.cli.main import app
from host.monitor.capture_rows import SHOWN, Rows
from host.monitor.capture_source import CaptureSource
from host.monitor.figures import figures_line
from host.monitor.health_panels import imu_lines
from host.monitor.motion_panels import attitude_lines
from host.monitor.view import MonitorView
from host.record.result import RunRequest
from host.record.tables import BIAS, GNSS, INNOVATION, SOLUTION
from host.run.runner import run


def monitor(*arguments: str):
    return CliRunner().invoke(app, ["monitor", *arguments])


def last_line(*arguments: str) -> dict:
    result = monitor(*arguments, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout.splitlines()[-1])


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


def test_a_capture_of_a_run_that_was_cut_off(tmp_path):
    part = write_capture(tmp_path / "run.mcap", spoken(20), finished=False)
    assert part.suffix == ".part"
    cut = tmp_path / "cut.mcap.part"
    cut.write_bytes(part.read_bytes()[:-5000])
    whole = last_line(str(part), "--once")
    assert whole["solution"]["t_s"] == 20.0
    assert "not whole" in whole["source"]
    result = monitor(str(cut), "--once", "--json")
    assert result.exit_code == 2  # one block, and that one is cut: nothing is left to show
    assert "nothing to show" in result.stderr


def test_json_lines_come_each_second_of_the_capture(tmp_path):
    path = write_capture(tmp_path / "run.mcap", spoken(8))
    result = monitor(str(path), "--json", "--speed", "0")
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert [round(line["t_s"]) for line in lines] == [1, 2, 3, 4, 5, 6, 7, 8, 8]
    # what was said up to the second, and nothing later
    assert [line["solution"]["t_s"] for line in lines[:4]] == pytest.approx([0.9, 1.9, 2.9, 3.9])


def test_pace_pause_and_jumps(tmp_path, monkeypatch):
    """A clock of our own: at double speed two seconds a second; a jump back begins anew and lands right."""
    clock = [100.0]
    monkeypatch.setattr("host.monitor.pace.time.monotonic", lambda: clock[0])
    source = CaptureSource(write_capture(tmp_path / "run.mcap", spoken(60)), 2.0)
    view = MonitorView("drive")

    def play(seconds: float) -> float:
        for _ in range(round(seconds * 10)):
            clock[0] += 0.1
            source.pump(view, 60.0)
        return source.now_s

    source.pump(view, 60.0)
    begin = source.now_s
    assert play(5.0) == pytest.approx(begin + 10.0, abs=0.01)
    assert view.state.solution.time_us == 9_900_000
    source.press(" ", view)
    assert play(3.0) == pytest.approx(begin + 10.0, abs=0.01)
    source.press(" ", view)
    source.press("right", view)
    source.pump(view, 60.0)
    assert source.now_s == pytest.approx(begin + 20.0, abs=0.01)
    assert play(1.0) == pytest.approx(begin + 22.0, abs=0.2)
    source.press("left", view)
    source.pump(view, 60.0)
    assert source.now_s == pytest.approx(begin + 12.0, abs=0.2)
    assert view.state.solution.time_us == pytest.approx(11.9e6, abs=2e5)
    source.press("-", view)
    assert play(1.0) == pytest.approx(begin + 13.0, abs=0.2)
    assert view.link.garbage_bytes == 0
    source.press("+", view)
    source.press("right", view)
    for _ in range(6):
        source.press("right", view)
        source.pump(view, 60.0)
    assert source.ended
    assert view.state.solution.time_us == 60_000_000


def test_a_board_is_run_and_shown():
    """Loads and activations are those that the run's own report tells, satellites those of its receiver."""
    shown = last_line("car_mems", "--scenario", "static", "--seconds", "30", "--once")
    request = RunRequest(
        board="car_mems",
        scenario="static",
        profile=None,
        seed=1,
        overrides=("profile.task_frames=true", "duration_s=30"),
        data_dir=None,
        out_dir=None,
        capture=False,
    )
    (cpu,) = run(request).cpu
    told = {task.name[:12]: task for task in cpu.tasks}
    seen = {task["name"]: task for task in shown["tasks"]}
    assert set(seen) == set(told)
    for name, task in seen.items():
        # told once a second, the last time up to a second before the end
        assert task["activations"] == pytest.approx(told[name].activations, rel=0.04, abs=12)
        assert task["worst_response_us"] <= told[name].worst_response_us
        assert task["busy_us"] / 29.5e6 == pytest.approx(told[name].load, rel=0.05, abs=1e-5)
        assert task["deadlines_missed"] == told[name].deadline_misses
    assert seen["navigation"]["load"] == pytest.approx(told["navigation"].load, rel=0.02)
    used = [one for one in shown["satellites"] if one["used"]]
    assert len(used) == shown["gnss"]["satellites_used"] > 8
    assert shown["solution"]["t_s"] == pytest.approx(30.0, abs=0.2)
    assert shown["link"]["garbage_bytes"] == shown["link"]["lost"] == shown["link"]["bad_crc"] == 0
    off = ("--seconds", "5", "--once", "--set", "profile.task_frames=false")
    assert last_line("car_mems", "--scenario", "static", *off)["tasks"] is None


@pytest.mark.parametrize("text", ["", "[]", '{"cpu": [{"tasks": 1}]}', '{"cpu": [{"tasks": [{"name": 1}]}]}'])
def test_task_load_of_a_run_that_did_not_tell_it(text, tmp_path):
    """The record of the run tells it for the whole run; a broken record tells nothing and breaks nothing."""
    writer = FrameWriter()
    said = solution(writer, 1.0) + writer.pack(STATUS, 1_000_000, 3, 0, *[1] * 7, 1, 1)
    write_capture(tmp_path / "run.mcap", [(1_000_000_000, said)])
    counts = {"activations": 5, "worst_response_us": 1234.5, "deadline_misses": 2}
    tasks = [{"name": "filter", "load": 0.125, **counts}]
    (tmp_path / "result.json").write_text(json.dumps({"cpu": [{"tasks": tasks}]}))
    told = monitor(str(tmp_path), "--once").stdout
    assert "whole run 12.5%  missed 2" in told
    assert "1234 µs" in told
    (tmp_path / "result.json").write_text(text)
    assert "task_frames = true" in monitor(str(tmp_path), "--once").stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["car_mem"], "did you mean 'car_mems'"),
        (["nothing.mcap"], "nothing.mcap"),
        (["car_mems", "--baud", "9600"], "--baud means nothing here: car_mems is a board"),
        (["/dev/ttyNoSuchPort"], "/dev/ttyNoSuchPort: there is no such port"),
        (["socket://127.0.0.1:1", "--speed", "2"], "--speed means nothing here"),
        (["socket://127.0.0.1:1", "--seed", "2"], "--seed means nothing here"),
        (["car_mems", "--scenario", "nowhere"], "no such scenario"),
        (["car_mems", "--once", "--size", "3x4000"], "--size 3x4000"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(arguments, words):
    result = monitor(*arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""


def test_a_foreign_file_and_an_empty_folder(tmp_path):
    (tmp_path / "notes.txt").write_text("words")
    assert "not a capture of navtwin" in monitor(str(tmp_path / "notes.txt")).stderr
    for size in (0, 5, 20, 100):
        (tmp_path / "short.mcap").write_bytes((b"\x89MCAP0\r\n" + bytes(100))[:size])
        result = monitor(str(tmp_path / "short.mcap"), "--once")
        assert result.exit_code == 2
        assert "not a capture of navtwin" in result.stderr
    (tmp_path / "folder").mkdir()
    assert "holds no run.mcap" in monitor(str(tmp_path / "folder")).stderr
    empty = CaptureWriter(tmp_path / "empty.mcap", manifest())
    empty.close({"state_hash": "0" * 64, "duration_s": "0.0"})
    result = monitor(str(tmp_path / "empty.mcap"), "--once")
    assert result.exit_code == 2
    assert "nothing to show" in result.stderr


class Terminal:
    """A monitor in a terminal of its own, 100 × 30."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        import fcntl

        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 100, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.output = bytearray()
        self.process = os.fork()
        if self.process == 0:
            os.setsid()
            fcntl.ioctl(self.slave, termios.TIOCSCTTY, 0)
            for descriptor in (0, 1, 2):
                os.dup2(self.slave, descriptor)
            environment = {**os.environ, "TERM": "xterm-256color"}
            environment.pop("NO_COLOR", None)
            command = [sys.executable, "-m", "host.cli.main", "monitor", *arguments]
            os.execve(sys.executable, command, environment)

    def wait_for(self, words: str, seconds: float = 15.0) -> None:
        """Until they stand on the screen."""
        end = time.monotonic() + seconds
        while words.encode() not in self.output:
            assert time.monotonic() < end, bytes(self.output[-3000:]).decode(errors="replace")
            self._read(0.1)

    def type(self, keys: bytes) -> None:
        os.write(self.master, keys)

    def end(self, seconds: float = 10.0) -> int:
        """Exit code of the program."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._read(0.05)
            process, status = os.waitpid(self.process, os.WNOHANG)
            if process:
                self._read(0.05)
                return os.waitstatus_to_exitcode(status)
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)
        raise AssertionError("the monitor did not end")

    def _read(self, seconds: float) -> None:
        ready, _, _ = select.select([self.master], [], [], seconds)
        if ready:
            self.output += os.read(self.master, 65536)


@pytest.mark.parametrize("leave", [b"\x03", b"q"])
def test_the_terminal_is_left_as_it_was(leave, tmp_path):
    path = write_capture(tmp_path / "run.mcap", spoken(60))
    terminal = Terminal(tmp_path, str(path))
    terminal.wait_for("navigating")
    assert termios.tcgetattr(terminal.slave) != terminal.before
    terminal.type(b" ")
    terminal.wait_for("paused")
    terminal.type(b"\x1b[C\x1b[C")
    terminal.wait_for("0:00:2")
    assert b"\x1b[?1049h" in terminal.output
    terminal.type(leave)
    assert terminal.end() == 0
    assert terminal.output.rindex(b"\x1b[?1049l") > terminal.output.rindex(b"\x1b[?1049h")
    assert b"\x1b[?25h" in terminal.output[-40:]
    assert termios.tcgetattr(terminal.slave) == terminal.before
    assert b"Traceback" not in terminal.output
