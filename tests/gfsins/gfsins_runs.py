"""Runs of the board that several tests look at; each is made once."""

from __future__ import annotations

import functools

from board_run import Driven

from host.record.result import RunRequest
from host.run.runner import run


@functools.cache
def drive(scenario: str, profile: str, *overrides: str) -> Driven:
    """One run; the scenario's expectations are the tests' own business."""
    given = ("expect={}", *overrides)
    return Driven(run(RunRequest("gfsins", scenario, profile=profile, overrides=given, capture=False)))
