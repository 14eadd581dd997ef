"""A port to look at: what the monitor says is what the link's decoder makes of the same bytes."""

import json
import os
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import pynmeagps
import pytest
from spoken_drive import SATELLITES, spoken
from spoken_receiver import sentences

from firmware.link import frames
from hal.live.port import PortError
from host.link.decoder import LinkDecoder
from host.monitor import port_source
from host.monitor.figures import figures
from host.monitor.port_source import PortSource
from host.monitor.view import MonitorView
from host.record.errors import UserError

MONITOR = [sys.executable, "-m", "host.cli.main", "monitor"]
WRITER = [sys.executable, str(Path(__file__).parent / "pty_writer.py")]


class Speaker:
    """The other program."""

    def __init__(self, path: Path, data: bytes, size: int = 200, pause: float = 0.001) -> None:
        path.write_bytes(data)
        command = [*WRITER, str(path), str(size), str(pause)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.port = self.process.stdout.readline().strip()

    def begin(self) -> None:
        self.process.stdin.write("go\n")
        self.process.stdin.flush()

    def written(self) -> None:
        assert self.process.stdout.readline() == "written\n"

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def speaker(tmp_path):
    made = []

    def make(data: bytes, **how) -> Speaker:
        made.append(Speaker(tmp_path / "bytes.bin", data, **how))
        return made[-1]

    yield make
    for one in made:
        one.end()


def decoded(data: bytes) -> tuple[LinkDecoder, dict]:
    """The decoder, and the last message of each kind."""
    decoder = LinkDecoder()
    return decoder, dict(decoder.feed(data))


def test_json_says_what_the_decoder_says(speaker):
    """Two programs and a pseudo-terminal between them; garbage and a broken frame in the middle."""
    pieces = [data for _, data in spoken(30)]
    broken = bytearray(pieces[100])
    broken[30] ^= 0x40
    data = b"".join([*pieces[:100], bytes(broken), b"\x00garbage\xff", *pieces[102:]])
    one = speaker(data)
    command = [*MONITOR, one.port, "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as monitor:
        lines = [json.loads(monitor.stdout.readline())]
        one.begin()
        while lines[-1]["link"]["bytes"] < len(data) and len(lines) < 15:
            lines.append(json.loads(monitor.stdout.readline()))
        monitor.send_signal(signal.SIGINT)
        _, err = monitor.communicate(timeout=20)
    assert (monitor.returncode, err) == (0, "")
    assert all(later["t_s"] - sooner["t_s"] > 0.9 for sooner, later in pairwise(lines))
    last = lines[-1]
    decoder, messages = decoded(data)
    for name in ("frames", "sentences", "bad_crc", "lost", "unknown", "garbage_bytes"):
        assert last["link"][name] == getattr(decoder, name), name
    assert last["link"]["bad_crc"] >= 1
    assert last["link"]["lost"] == 2
    assert last["link"]["bytes"] == len(data)
    solution = messages[frames.SOLUTION]
    shown = last["solution"]
    assert shown["t_s"] == pytest.approx(solution.time_us * 1e-6, abs=1e-9)
    assert shown["latitude_deg"] == pytest.approx(solution.lat_nanodeg * 1e-9, abs=1e-12)
    assert shown["longitude_deg"] == pytest.approx(solution.lon_nanodeg * 1e-9, abs=1e-12)
    assert shown["v_north_mps"] == solution.v_n
    assert shown["mode"] == solution.mode
    assert shown["flags"] == solution.flags
    assert last["status"]["imu_reads"] == messages[frames.STATUS].imu_reads
    assert last["innovation"]["v_down_mps"] == messages[frames.INNOVATION].values[5]
    assert last["bias"]["latency_s"] == messages[frames.BIAS].values[8]
    assert last["gnss"]["satellites_used"] == messages[frames.GNSS].satellites
    assert [tuple(one.values()) for one in last["satellites"]] == [tuple(one) for one in SATELLITES]
    assert {one["name"]: one["activations"] for one in last["tasks"]} == {
        one.name: one.activations for one in messages[frames.TASKS].tasks
    }
    assert {one["name"]: one["load"] for one in last["tasks"]} == pytest.approx(
        {"imu_ready": 0.02, "navigation": 0.031, "filter": 0.0015, "output": 0.004}, rel=1e-3
    )
    assert last["events"][0]["text"] == "mode: navigating"


def test_a_plain_receiver_is_recognised():
    data = sentences(20)
    last = None
    for raw in data.split(b"\r\n"):
        if raw.startswith(b"$GPRMC"):
            last = pynmeagps.NMEAReader.parse(raw + b"\r\n")
    view = MonitorView("?")
    for t, epoch in enumerate(data.split(b"$GPRMC")[1:]):
        for k, piece in enumerate((b"$GPRMC" + epoch[:90], epoch[90:])):
            view.feed(piece, t + k * 0.01)
        view.time_passes(t + 0.5)
    shown = figures(view)
    assert shown["solution"] is None
    assert shown["gnss"]["fix"] == "3D"
    assert shown["gnss"]["latitude_deg"] == pytest.approx(last.lat, abs=1e-9)
    assert shown["gnss"]["longitude_deg"] == pytest.approx(last.lon, abs=1e-9)
    assert shown["gnss"]["speed_mps"] == pytest.approx(5.0, abs=1e-3)
    assert shown["gnss"]["satellites_used"] == 5
    seen = [
        (one["number"], one["elevation_deg"], one["cn0_dbhz"], one["used"]) for one in shown["satellites"]
    ]
    assert seen == [(5, 62, 47, True), (13, 35, 41, True), (15, 20, 33, True), (20, 5, None, True)]
    assert shown["track"]["gnss_points"] >= 18
    assert shown["link"]["sentences"] == 80
    assert shown["link"]["bad_crc"] == 0


def test_a_board_beside_its_sentences_is_no_receiver():
    """INGGA and INHDT of the board itself are not taken for a second receiver."""
    view = MonitorView("a board")
    for time_ns, data in spoken(12):
        view.feed(data, time_ns / 1e9)
    assert view.listener.receiver is None
    assert view.link.sentences == 12


def test_the_rate_is_looked_for_until_something_is_understood(speaker, monkeypatch):
    monkeypatch.setattr(port_source, "PATIENCE_S", 0.15)
    rates: list[int] = []
    garbage = bytes(range(1, 90)) * 40
    one = speaker(garbage * 3 + b"".join(data for _, data in spoken(5)), size=2000, pause=0.06)
    source = PortSource(one.port, None)
    view = MonitorView("?")
    try:
        one.begin()
        deadline = time.monotonic() + 8.0
        while view.state.solution is None and time.monotonic() < deadline:
            source.pump(view, 0.05)
            if "looking for the rate" in view.source:
                rates.append(int(view.source.split(" baud")[0].rpartition(" ")[2]))
            time.sleep(0.01)
        one.written()
        source.pump(view, 0.05)
    finally:
        source.close()
    assert view.state.solution is not None
    assert rates[:1] == [115_200]
    assert "looking" not in view.source


def test_a_flood_does_not_starve_the_picture(speaker):
    """Sixteen megabytes of false starts: every look ends in time, and what was not looked at is told."""
    one = speaker(b"\xa5\x5a\x01\xff" * 4_000_000, size=65536, pause=0.0)
    source = PortSource(one.port, 230_400)
    view = MonitorView("flood")
    longest = 0.0
    try:
        one.begin()
        end = time.monotonic() + 2.0
        while time.monotonic() < end:
            began = time.process_time()
            source.pump(view, 0.02)
            longest = max(longest, time.process_time() - began)
    finally:
        source.close()
    assert view.link.bytes > 100_000
    assert view.link.frames == 0
    assert longest < 0.5


def test_a_port_that_vanishes_is_told_and_waited_for(speaker):
    one = speaker(b"".join(data for _, data in spoken(3)))
    source = PortSource(one.port, None)
    view = MonitorView("?")
    try:
        one.begin()
        one.written()
        end = time.monotonic() + 2.0
        while view.state.solution is None and time.monotonic() < end:
            source.pump(view, 0.05)
            time.sleep(0.01)
        one.end()
        while "port is gone" not in view.source and time.monotonic() < end + 3.0:
            source.pump(view, 0.05)
            time.sleep(0.01)
    finally:
        source.close()
    assert "port is gone" in view.source
    assert view.source_style == "bold red"
    assert view.state.solution is not None


@pytest.mark.parametrize("url", ["/dev/ttyNoSuchPort", "socket://127.0.0.1:1"])
def test_a_port_that_cannot_be_had_is_explained(url):
    with pytest.raises(UserError, match=url):
        PortSource(url, None)
    assert issubclass(UserError, Exception)
    assert not issubclass(UserError, PortError)


def test_a_busy_port_is_told(speaker):
    one = speaker(b"")
    first = PortSource(one.port, None)
    try:
        with pytest.raises(UserError, match="in use by"):
            PortSource(one.port, None)
    finally:
        first.close()
    assert os.path.exists(one.port)
