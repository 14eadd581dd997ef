"""Processes that share a piece of work: one does it, the others leave it or wait."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from firmware.numerics.claims import claim

HOLDER = """
import sys
from pathlib import Path
from firmware.numerics.claims import claim
with claim(Path(sys.argv[1])) as ours:
    print(ours, flush=True)
    sys.stdin.readline()
"""


def _holder(path: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", HOLDER, str(path)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "True\n"
    return process


def test_a_piece_that_another_process_has_is_left_to_it(tmp_path: Path) -> None:
    with _holder(tmp_path / "piece") as other:
        with claim(tmp_path / "piece") as ours:
            assert not ours
        with claim(tmp_path / "another piece") as ours:
            assert ours
        other.communicate("\n")
    with claim(tmp_path / "piece") as ours:
        assert ours


def test_who_waits_gets_it_when_the_other_process_ends_however_it_ends(tmp_path: Path) -> None:
    with _holder(tmp_path / "piece") as other:
        other.kill()
        with claim(tmp_path / "piece", wait=True) as ours:
            assert ours


def test_where_nothing_can_be_locked_everybody_does_everything(tmp_path: Path) -> None:
    with claim(tmp_path / "no such folder" / "piece") as ours:
        assert ours
