"""All code is there before virtual time begins, and the first run of all does not take long."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMPILED_LATE = """
import sys
from numba.core import event
import host.run.runner as runner
from host.record.result import RunRequest
seen = []
class Listener(event.Listener):
    def on_start(self, event):
        seen.append(event.data["dispatcher"].py_func.__qualname__)
    def on_end(self, event):
        pass
work_off = runner._work_off
def watched(*arguments):
    event.register("numba:compile", Listener())
    return work_off(*arguments)
runner._work_off = watched
runner.run(RunRequest("car_mems", "outages", sys.argv[1], overrides=("duration_s=330",)))
print(seen)
"""


@pytest.mark.parametrize("profile", ["full-rate", "thesis"])
def test_nothing_is_compiled_in_virtual_time(profile: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", COMPILED_LATE, profile], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.soak
def test_first_run_of_all_takes_at_most_20_s_of_two_cores_and_says_that_it_compiles(tmp_path: Path) -> None:
    """Processor time of the run and of who helps it compile: others on the machine hardly count."""
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    arguments = ["run", "car_mems", "--scenario", "town", "-q", "--out", str(tmp_path / "out")]
    begin = os.times()
    done = subprocess.run(
        [sys.executable, "-m", "host.cli.main", *arguments], env=environment, capture_output=True, text=True
    )
    end = os.times()
    worked_s = end.children_user - begin.children_user + end.children_system - begin.children_system
    assert worked_s <= 2 * 20.0
    assert done.returncode == 0
    assert "compiling the on-board kernels (first run" in done.stderr
