"""Runs of the board that several tests look at; each is made once."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.record.result import RunRequest, RunResult
from host.run.runner import run


@dataclass(frozen=True)
class Flown:
    """A run, and what the board said."""

    result: RunResult

    def column(self, name: str) -> NDArray[np.float64]:
        """Of its solutions (thinned where there are many)."""
        assert self.result.data is not None
        return self.result.data.solution.column(name)

    def words(self) -> list[tuple[float, str]]:
        """(s, text) of everything the board said."""
        return [(event.at_s, event.text) for event in self.result.events if event.source == "board"]

    def said(self, text: str, after_s: float = 0.0) -> float:
        """When it first said something that begins like this."""
        for at_s, words in self.words():
            if at_s >= after_s and words.startswith(text):
                return at_s
        raise AssertionError(f"never said {text!r}; it said {self.words()}")

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
