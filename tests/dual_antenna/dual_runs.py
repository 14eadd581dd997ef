"""Runs of the board that several tests look at; each is made once."""

from __future__ import annotations

import functools
from pathlib import Path

from board_run import Driven

from host.record.result import RunRequest
from host.run.runner import run

UNIT, RECEIVER = "U3", "U4"


@functools.cache
def drive(scenario: str, *overrides: str, profile: str | None = None, out: Path | None = None) -> Driven:
    """One run; the scenario's expectations are the tests' own business."""
    request = RunRequest(
        "dual_antenna",
        scenario,
        profile=profile,
        overrides=("expect={}", *overrides),
        out_dir=out,
        capture=out is not None,
    )
    return Driven(run(request))
