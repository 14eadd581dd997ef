"""Runs of the board that several tests look at; each is made once."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from board_run import Driven

from host.record.result import RunRequest
from host.run.runner import run


class Flown(Driven):
    """Of an attitude computer."""

    def worst_deg(self, from_s: float, to_s: float) -> float:
        """Largest error of any angle between two times."""
        t = self.column("t_s")
        inside = (t >= from_s) & (t <= to_s) & (self.column("mode") >= 3)
        errors = [np.abs(self.column(f"error_{name}_deg")[inside]) for name in ("roll", "pitch", "yaw")]
        return float(np.max(errors))


@functools.cache
def fly(
    scenario: str = "static",
    profile: str | None = None,
    *overrides: str,
    out: Path | None = None,
    seed: int = 1,
) -> Flown:
    """A run of the board; `overrides` as for --set."""
    request = RunRequest(
        "uav_ahrs", scenario, profile, seed, (*overrides,), out_dir=out, capture=out is not None
    )
    return Flown(run(request))
