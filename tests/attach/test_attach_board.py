"""`navtwin attach board` on ports that a board could be behind: quiet, wrong, unplugged, killed."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from attached_board import BAUD, Adapter, frames_of, said, saying

from firmware.link.frames import SOLUTION
from host.capture.blocks import UartChunk
from host.capture.reader import CaptureReader
from host.cli.attach_run_board import BoardRequest, attach_board
from host.record.errors import UserError

ROOT = Path(__file__).parents[2]


@pytest.fixture
def adapter(tmp_path):
    one = Adapter(tmp_path / "ttyBOARD", BAUD)
    yield one
    one.close()


def attached(tmp_path, port, seconds, **more):
    """(exit code, the JSON)."""
    request = BoardRequest(
        port=str(port),
        board=None,
        profile=more.get("profile"),
        overrides=more.get("overrides", ()),
        baud=more.get("baud"),
        out_dir=tmp_path / "kept",
        seconds=seconds,
        shadow=more.get("shadow", True),
    )
    code = attach_board(request, str(tmp_path / "told.json"), quiet=True)
    return code, json.loads((tmp_path / "told.json").read_text())


def recorded(folder):
    """Every byte in the recording."""
    name = "run.mcap" if (folder / "run.mcap").exists() else "run.mcap.part"
    chunks = [one for one in CaptureReader(folder / name) if isinstance(one, UartChunk)]
    times = [one.end_ns for one in chunks]
    assert times == sorted(times)
    return b"".join(one.data for one in chunks)


def test_a_board_on_a_port_is_shadowed_and_recorded(tmp_path, adapter):
    data = said()
    with saying(adapter, 0.1, data):
        code, told = attached(tmp_path, adapter.path, 2.0)
    solutions = sum(kind == SOLUTION for kind, _ in frames_of(data))
    assert code == 0
    assert told["ok"]
    assert told["compared"]
    assert told["shadow"]["solutions_equal"] == solutions
    assert told["shadow"]["losses"] == 0
    assert recorded(tmp_path / "kept") == data
    with (tmp_path / "kept" / "solution.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == solutions
    assert float(rows[-1]["board_s"]) == pytest.approx(25.0, abs=0.2)
    (tmp_path / "again").mkdir()
    again, told_again = attached(tmp_path / "again", tmp_path / "kept", None)
    assert again == 0
    assert told_again["shadow"] == told["shadow"]


def test_a_difference_ends_with_one(tmp_path, adapter):
    with saying(adapter, 0.1, said("full-rate", 16, "profile.initial_yaw_deg=62.0")):
        code, told = attached(tmp_path, adapter.path, 1.8)
    assert code == 1
    assert {one["what"] for one in told["shadow"]["differences"]} == {"start", "state", "solution"}


@pytest.mark.soak
def test_bytes_that_are_lost_or_wrong_are_no_difference(tmp_path, adapter):
    data = said()
    spoilt = bytearray(data[: len(data) // 3] + data[len(data) // 3 + 500 :])
    spoilt[2000] ^= 0x10
    with saying(adapter, 0.1, bytes(spoilt)):
        code, told = attached(tmp_path, adapter.path, 2.0)
    assert code == 0
    assert told["link"]["bad_crc"] >= 1
    assert told["shadow"]["losses"] >= 1
    assert told["shadow"]["solutions_equal"] > 50
    assert told["shadow"]["differences"] == []


def test_unplugged_and_plugged_in_again(tmp_path, adapter):
    import threading

    data = said()
    half = len(data) // 3

    def work():
        time.sleep(0.2)
        adapter.say(data[:half])
        time.sleep(0.3)
        adapter.unplug()
        time.sleep(0.5)
        adapter.plug_in()
        time.sleep(0.9)
        adapter.say(data[half + 3000 :])

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    code, told = attached(tmp_path, adapter.path, 3.5)
    thread.join(10)
    assert code == 0
    assert (told["line"]["port_losses"], told["line"]["port_reopenings"]) == (1, 1)
    assert told["shadow"]["joined"] == 1
    assert told["shadow"]["differences"] == []


@pytest.mark.soak
def test_another_rate_is_found(tmp_path):
    slow = Adapter(tmp_path / "ttySLOW", 115_200)
    data = said()
    with saying(slow, 0.1, data[:2000], 1.7, data):
        code, told = attached(tmp_path, slow.path, 3.4)
    slow.close()
    assert code == 0
    assert told["line"]["baud"] == 115_200
    assert told["shadow"]["solutions_equal"] > 200


@pytest.mark.soak
def test_a_rate_that_was_given_is_kept_and_explained(tmp_path, adapter, capsys):
    with saying(adapter, 0.1, said()[:5000]), pytest.raises(UserError, match="not one frame of our link"):
        attached(tmp_path, adapter.path, 2.0, baud=9600)


def test_a_board_without_raw_frames(tmp_path, adapter):
    data = said("full-rate", 6, "profile.raw_output=false")
    with saying(adapter, 0.1, data), pytest.raises(UserError, match=r"raw_output.*--no-shadow"):
        attached(tmp_path, adapter.path, 1.2)
    with saying(adapter, 0.1, data):
        code, told = attached(tmp_path, adapter.path, 1.2, shadow=False)
    assert code == 0
    assert told["shadow"] is None
    assert told["link"]["solutions"] == 59


@pytest.mark.parametrize(
    ("port", "words"),
    [
        ("/dev/ttyNOWHERE", "there is no such port"),
        ("socket://127.0.0.1:1", "nobody answers"),
        ("nonsense://x", "is no serial port"),
        ("{tmp}", "holds no run.mcap"),
        ("{file}", "not a capture of navtwin"),
    ],
)
def test_what_is_no_board(tmp_path, port, words):
    (tmp_path / "file").write_bytes(os.urandom(3000))
    given = port.format(tmp=tmp_path, file=tmp_path / "file")
    with pytest.raises(UserError, match=words):
        attached(tmp_path, given, 1.0)
    assert not (tmp_path / "kept").exists()


def test_a_silent_port(tmp_path, adapter):
    with pytest.raises(UserError, match="nothing came"):
        attached(tmp_path, adapter.path, 0.5)


def test_a_kill_loses_less_than_a_second(tmp_path, adapter):
    data = said()
    command = [sys.executable, "-m", "host.cli.main", "attach", "board", "--port", str(adapter.path)]
    process = subprocess.Popen([*command, "--out", str(tmp_path / "kept"), "-q"], cwd=ROOT)
    part = tmp_path / "kept" / "run.mcap.part"
    while not part.exists():
        assert process.poll() is None
        time.sleep(0.05)
    adapter.say(data[:100_000])
    time.sleep(1.0)
    adapter.say(data[100_000:101_000])
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = recorded(tmp_path / "kept")
    assert len(kept) >= 100_000
    assert data.startswith(kept)
    assert json.loads((tmp_path / "kept" / "manifest.json").read_text())["status"] == "running"
