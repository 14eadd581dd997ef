"""The command line where things go wrong around it: signals, full and shared folders, odd terminals."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from host.capture.reader import CaptureReader

NAVTWIN = [sys.executable, "-m", "host.cli.main"]
SHORT = ["run", "car_mems", "-s", "static", "--set", "duration_s=20", "--set", "expect={deadline_misses=0}"]
LONG = ["run", "car_mems", "-s", "static", "--set", "duration_s=90000", "-q"]


def _navtwin(*arguments: str, **environment: str | None) -> subprocess.CompletedProcess[bytes]:
    changed = {**os.environ, **environment}
    kept = {name: value for name, value in changed.items() if value is not None}
    return subprocess.run([*NAVTWIN, *arguments], env=kept, capture_output=True)


def _started(out: Path) -> subprocess.Popen[bytes]:
    """A long run that has written some of its capture."""
    process = subprocess.Popen([*NAVTWIN, *LONG, "--out", str(out)], stderr=subprocess.PIPE)
    part = out / "run.mcap.part"
    for _ in range(600):
        if part.is_file() and part.stat().st_size > 100_000:
            return process
        assert process.poll() is None
        time.sleep(0.1)
    process.kill()
    raise AssertionError("the run has written nothing for a minute")


def _status(out: Path) -> str:
    status: str = json.loads((out / "manifest.json").read_text())["status"]
    return status


@pytest.mark.parametrize("way", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_what_it_has_and_says_so(tmp_path: Path, way: signal.Signals) -> None:
    with _started(tmp_path / "out") as process:
        process.send_signal(way)
        _, told = process.communicate()
    assert process.returncode == 130
    assert told.decode() == "navtwin: interrupted; what was written so far is marked as incomplete\n"
    assert _status(tmp_path / "out") == "interrupted by the user"
    assert sum(1 for _ in CaptureReader(tmp_path / "out" / "run.mcap.part").messages()) > 0


@pytest.mark.soak
def test_a_killed_run_leaves_a_capture_that_is_read_and_a_folder_that_is_used_again(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with _started(out) as process:
        second = _navtwin(*SHORT, "--out", str(out))
        assert second.returncode == 2
        assert b"another run is writing there" in second.stderr
        process.kill()
    assert _status(out) == "running"
    assert sum(1 for _ in CaptureReader(out / "run.mcap.part").messages()) > 0
    (out / "log_of_another_board.bin").write_bytes(b"old")
    assert _navtwin(*SHORT, "--no-capture", "--out", str(out)).returncode == 0
    assert _status(out) == "complete"
    names = {path.name for path in out.iterdir()}
    assert not names & {"run.mcap.part", "solution.csv.part", "log_of_another_board.bin"}


@pytest.mark.parametrize(
    "environment",
    [
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"},
        {"PYTHONIOENCODING": "latin-1"},
        {"COLUMNS": "40", "NO_COLOR": "1"},
        {"TERM": "dumb"},
        {"HOME": None, "XDG_CACHE_HOME": None},
    ],
    ids=lambda environment: ",".join(environment),
)
@pytest.mark.soak
def test_odd_surroundings_make_no_difference(tmp_path: Path, environment: dict[str, str | None]) -> None:
    done = _navtwin(*SHORT, "--no-capture", "--out", str(tmp_path / "out"), **environment)
    assert b"Traceback" not in done.stderr
    assert done.returncode == 0
    assert b"\x1b[" not in done.stdout
    assert b"all 2 expectations met" in done.stdout


def test_a_terminal_that_knows_ascii_only_shows_every_sign(tmp_path: Path) -> None:
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"}
    done = _navtwin(*SHORT, "--no-capture", "--out", str(tmp_path / "out"), **ascii_only)
    assert b"<= 0" in done.stdout
    assert b"real time" in done.stdout
    assert b"?" not in done.stdout


def test_a_full_disk_is_told_and_marked(tmp_path: Path) -> None:
    out = tmp_path / "out"
    limited = (
        "import resource, signal, sys\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))\n"
        "from host.cli.main import main\n"
        "main()\n"
    )
    arguments = [*SHORT[:4], "--set", "duration_s=400", "-q", "--out", str(out)]
    done = subprocess.run([sys.executable, "-c", limited, *arguments], capture_output=True, text=True)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert f"--out {out}: cannot be written" in done.stderr
    assert _status(out).startswith("failed: ")
    assert not (out / "result.json").exists()
