"""Faults on what joins the processors are in no recorded traffic; a strict replay has them again."""

from __future__ import annotations

from pathlib import Path

from board_run import fault

from host.record.result import RunRequest
from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict
from host.run.runner import run

FAULTS = (
    fault("i2c-stuck", "commands", 3.0, 1.5),
    fault("pin-stuck", "SYNC", 5.0, 1.0),
    fault("packet-loss", "packets", 6.5, 1.0, probability=0.2),
)


def test_faults_between_processors_repeat(tmp_path: Path) -> None:
    given = ("expect={}", "duration_s=9", "profile.alignment_s=2", f"fault=[{', '.join(FAULTS)}]")
    made = run(RunRequest("gfsins", "static", profile="adxl345", overrides=given, out_dir=tmp_path))
    assert all(one.fired for one in made.faults)
    replayed = replay_strict(ReplayRequest(tmp_path / "run.mcap"))
    assert replayed.difference is None
    assert replayed.state_hash == made.state_hash
