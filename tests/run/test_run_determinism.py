"""The same request gives the same bytes; the noise of one sensor is its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from short_drive import SHORT_DRIVE, drive

from host.record.result import RunRequest
from host.run.runner import run

CUT = "duration_s=60"
FILES = ("solution.csv", "run.mcap", "sdcard.bin", "report.html")
WALL = ("wall_s", "real_time_factor", "out_dir")


def _files(folder: Path, seed: int = 1) -> dict[str, bytes]:
    run(RunRequest("car_mems", str(SHORT_DRIVE), seed=seed, overrides=(CUT,), out_dir=folder))
    return {name: (folder / name).read_bytes() for name in FILES}


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("runs") / "first"
    return folder, _files(folder)


def test_two_runs_write_the_same_bytes(first: tuple[Path, dict[str, bytes]], tmp_path: Path) -> None:
    folder, files = first
    again = _files(tmp_path / "again")
    for name in ("solution.csv", "run.mcap", "sdcard.bin"):
        assert files[name], name
        assert files[name] == again[name], name
    figures = []
    for where in (folder, tmp_path / "again"):
        document = json.loads((where / "result.json").read_text())
        figures.append({key: value for key, value in document.items() if key not in WALL})
    assert figures[0] == figures[1]


def test_another_seed_writes_others(first: tuple[Path, dict[str, bytes]], tmp_path: Path) -> None:
    other = _files(tmp_path / "other", seed=2)
    assert other["solution.csv"] != first[1]["solution.csv"]
    assert other["sdcard.bin"] != first[1]["sdcard.bin"]


@pytest.mark.parametrize("profile", ["full-rate", "thesis"])
def test_interpreted_kernels_and_engine_end_in_the_same_state(profile: str) -> None:
    script = (
        "from host.record.result import RunRequest; from host.run.runner import run;"
        f"print(run(RunRequest('car_mems', {str(SHORT_DRIVE)!r}, {profile!r}, 1, ({CUT!r},))).state_hash)"
    )
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "NAVTWIN_ENGINE": "interpreted"}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == drive(CUT, profile=profile).result.state_hash


def test_noise_of_the_receiver_is_no_noise_of_the_gyro() -> None:
    """Levelled and before the first epoch counts, only the inertial sensor speaks."""
    plain = drive(CUT)
    noisy = drive(CUT, "gnss.position_white_m=0.7")
    assert plain.result.state_hash != noisy.result.state_hash
    still = (plain.t > 12.0) & (plain.t < 24.0)
    for name in ("pitch_deg", "roll_deg"):
        assert np.array_equal(plain.column(name)[still], noisy.column(name)[still])
    assert np.ptp(plain.column("roll_deg")[still]) > 0.0


def test_noise_of_the_gyro_is_no_noise_of_the_receiver() -> None:
    def epochs(*overrides: str) -> tuple[list[float], list[float]]:
        data = drive(CUT, *overrides).result.data
        assert data is not None
        return data.gnss.column("error_north_m").tolist(), data.gnss.column("error_v_east_mps").tolist()

    assert epochs() == epochs('imu.preset="perfect"')


def test_the_manifest_holds_all_that_the_scenario_is_made_of(tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(RunRequest("car_mems", "town", overrides=("duration_s=3.0",), out_dir=out, capture=False))
    text = json.loads((out / "manifest.json").read_text())["scenario_text"]
    assert 'inherit = "town-open"' in text
    assert "[[outage]]" in text
    assert 'kind = "reach-speed"' in text
