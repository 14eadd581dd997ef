"""`navtwin attach gnss` in real time, with receivers in processes of their own."""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import termios
import threading
import time
import tty
from pathlib import Path

import pytest

from host.recovery.whole_reader import WholeReader
from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
LATITUDE, LONGITUDE = 48.1173, 11.5167
DATA = os.environ.get("NAVTWIN_DATA")
LATENCY_MS = 60.0


class Double:
    """A receiver in a process of its own."""

    def __init__(self, script: str, *arguments: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(HERE / script), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout.readline() == "ready\n"

    def tell(self, word: str) -> None:
        self._process.stdin.write(word + "\n")
        self._process.stdin.flush()
        assert self._process.stdout.readline() == "done\n"

    def end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._process.stdin.close()
        self._process.stdout.close()


@pytest.fixture
def double():
    made = []

    def make(script: str, *arguments: str) -> Double:
        made.append(Double(script, *arguments))
        return made[-1]

    yield make
    for one in made:
        one.end()


def start(tmp_path: Path, port: str, *more: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "host.cli.main", "attach", "gnss", "--port", port]
    out = ["--out", str(tmp_path / "out"), "--json", str(tmp_path / "told.json")]
    return subprocess.Popen([*command, *out, *more], cwd=ROOT, stderr=subprocess.PIPE, text=True)


def wait_until_it_runs(tmp_path: Path) -> None:
    """The port is open, the fix is there, the board is switched on."""
    deadline = time.monotonic() + 90.0
    while not (tmp_path / "out" / "manifest.json").exists():
        assert time.monotonic() < deadline
        time.sleep(0.1)


def ended(tmp_path: Path, process: subprocess.Popen) -> tuple[int, dict, str]:
    """(exit code, the JSON, what was said)."""
    _, said = process.communicate(timeout=120)
    told = tmp_path / "told.json"
    return process.returncode, json.loads(told.read_text()) if told.exists() else {}, said


def assert_it_replays(tmp_path: Path, told: dict) -> None:
    replayed = replay_strict(ReplayRequest(tmp_path / "out" / "run.mcap", None, None, None))
    assert replayed.difference is None
    assert replayed.ok
    assert replayed.state_hash == told["state_hash"]


def test_a_receiver_is_configured_and_used(tmp_path, double):
    name = str(tmp_path / "ttyGPS")
    double("simulated_receiver.py", name)
    code, told, said = ended(tmp_path, start(tmp_path, name, "--seconds", "5"))
    assert code == 0, said
    assert (told["baud"], told["rate_changes"]) == (115_200, 1)
    assert told["bytes_to_receiver"] >= 28
    assert told["epochs_used"] >= 2
    assert told["first_fix"]["latitude_deg"] == pytest.approx(LATITUDE, abs=2e-5)
    assert told["first_fix"]["longitude_deg"] == pytest.approx(LONGITUDE, abs=2e-5)
    assert LATENCY_MS - 5 <= told["latency"]["latency_median_ms"] < LATENCY_MS + 100
    assert_it_replays(tmp_path, told)


def test_over_tcp_there_is_no_rate_and_the_boards_changes_count_once_each(tmp_path, double):
    name = str(tmp_path / "ttyGPS")
    double("simulated_receiver.py", name, "--deaf")
    terminal = os.open(name, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(terminal)
    attributes = termios.tcgetattr(terminal)
    attributes[4] = attributes[5] = termios.B9600
    termios.tcsetattr(terminal, termios.TCSANOW, attributes)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        threading.Thread(target=relay, args=(listener, terminal), daemon=True).start()
        port = f"socket://127.0.0.1:{listener.getsockname()[1]}"
        code, told, said = ended(tmp_path, start(tmp_path, port, "--seconds", "5"))
    assert code == 0, said
    assert told["baud"] is None
    assert 1 <= told["rate_changes"] <= 20
    assert told["epochs_used"] >= 2


@pytest.mark.soak
@pytest.mark.parametrize("after_s", [1.3, 4.1, 7.7])
def test_a_kill_leaves_rows_up_to_the_last_second(after_s, tmp_path, double):
    name = str(tmp_path / "ttyGPS")
    double("simulated_receiver.py", name)
    process = start(tmp_path, name, "--seconds", "60")
    wait_until_it_runs(tmp_path)
    time.sleep(after_s)
    process.kill()
    process.communicate()
    capture = tmp_path / "out" / "run.mcap.part"
    reader = WholeReader(capture)
    solutions = [one.time_ns for one in reader if getattr(one, "topic", "") == "/solution"]
    replayed = replay_strict(ReplayRequest(capture))
    assert replayed.ok
    assert after_s - 2.0 < replayed.duration_s
    assert replayed.duration_s - solutions[-1] / 1e9 < 0.5
    assert not reader.notes


def relay(listener: socket.socket, terminal: int) -> None:
    """Bytes both ways between one connection and a terminal, up to the end."""
    connection, _ = listener.accept()
    with connection, contextlib.suppress(OSError):
        while True:
            for ready in select.select([connection, terminal], [], [])[0]:
                if ready is connection:
                    os.write(terminal, connection.recv(4096))
                else:
                    connection.sendall(os.read(terminal, 4096))


def test_a_moving_scenario_is_refused_before_anything_is_opened(tmp_path):
    code, told, said = ended(tmp_path, start(tmp_path, "/dev/ttyNOWHERE", "--scenario", "town-open"))
    assert (code, told) == (2, {})
    assert "its vehicle moves" in said
    assert len(said.strip().splitlines()) == 1


@pytest.mark.soak
def test_one_that_does_not_obey_is_used_all_the_same(tmp_path, double):
    name = str(tmp_path / "ttyDEAF")
    double("simulated_receiver.py", name, "--deaf")
    code, told, said = ended(tmp_path, start(tmp_path, name, "--seconds", "20"))
    assert code == 0, said
    assert told["epochs_used"] >= 4
    assert_it_replays(tmp_path, told)


@pytest.mark.soak
def test_one_at_another_rate_is_found(tmp_path, double):
    name = str(tmp_path / "tty38400")
    double("simulated_receiver.py", name, "--baud", "38400")
    code, told, said = ended(tmp_path, start(tmp_path, name, "--seconds", "15"))
    assert code == 0, said
    assert told["baud"] == 115_200
    assert told["epochs_used"] >= 8


@pytest.mark.soak
def test_one_without_a_fix_ends_with_a_message(tmp_path, double):
    name = str(tmp_path / "ttyINDOORS")
    double("simulated_receiver.py", name, "--no-fix")
    code, told, said = ended(tmp_path, start(tmp_path, name, "--wait", "4"))
    assert (code, told) == (2, {})
    assert "no fix within 4 s" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.soak
def test_unplugged_silent_and_back(tmp_path, double):
    name = str(tmp_path / "ttyUSB")
    receiver = double("simulated_receiver.py", name)
    process = start(tmp_path, name)
    wait_until_it_runs(tmp_path)
    time.sleep(8)
    receiver.tell("unplug")
    time.sleep(4)
    receiver.tell("plug")
    time.sleep(8)
    receiver.tell("silence")
    time.sleep(5)
    receiver.tell("talk")
    time.sleep(9)
    process.send_signal(signal.SIGINT)
    code, told, said = ended(tmp_path, process)
    assert code == 0, said
    assert (told["port_losses"], told["port_reopenings"]) == (1, 1)
    assert "GNSS is back" in said
    assert_it_replays(tmp_path, told)


@pytest.mark.soak
def test_a_drive_is_recorded_only(tmp_path, double):
    name = str(tmp_path / "ttyREC")
    double("simulated_receiver.py", name)
    more = ("--scenario", "town-open", "--record-only", "--seconds", "6")
    code, told, said = ended(tmp_path, start(tmp_path, name, *more))
    assert code == 0, said
    assert told["scatter"] is None
    assert_it_replays(tmp_path, told)


@pytest.mark.soak
@pytest.mark.recording
@pytest.mark.parametrize("way", ["terminal", "tcp", "socat"])
def test_a_recorded_receiver(tmp_path, double, way):
    if DATA is None:
        pytest.skip("NAVTWIN_DATA is not set")
    if way == "socat" and shutil.which("socat") is None:
        pytest.skip("socat is not installed")
    log = str(Path(DATA) / "gnss" / "neo-m8n.log")
    name = str(tmp_path / "ttyLOG")
    number = str(20_000 + os.getpid() % 20_000)
    double("log_player.py", log, name if way == "terminal" else number)
    relay = None
    if way == "socat":
        relay = subprocess.Popen(["socat", f"PTY,link={name},raw,echo=0", f"TCP:127.0.0.1:{number}"])
        while not Path(name).is_symlink():
            time.sleep(0.05)
    port = f"socket://127.0.0.1:{number}" if way == "tcp" else name
    code, told, said = ended(tmp_path, start(tmp_path, port, "--seconds", "10", "-p", "thesis"))
    if relay is not None:
        relay.kill()
        relay.wait()
    assert code == 0, said
    assert told["epochs_used"] >= 8
    assert told["first_fix"]["utc"].startswith("2015-03-18T")
    assert "latency_median_ms" not in told["latency"]
    assert_it_replays(tmp_path, told)


@pytest.mark.soak
def test_a_port_in_use_is_told(tmp_path, double):
    name = str(tmp_path / "ttyBUSY")
    double("simulated_receiver.py", name)
    first = start(tmp_path, name, "--seconds", "10")
    wait_until_it_runs(tmp_path)
    (tmp_path / "second").mkdir()
    code, _, said = ended(tmp_path / "second", start(tmp_path / "second", name, "--baud", "9600"))
    assert code == 2
    assert "in use by" in said
    assert ended(tmp_path, first)[0] == 0
