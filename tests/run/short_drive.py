"""A short drive with something broken in it, and what the board made of that."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.record.result import RunRequest, RunResult
from host.run.runner import run

SHORT_DRIVE = Path(__file__).with_name("short_drive.toml")
FAULT_AT_S = 100.0
"""At 13 m/s; a turn of 90° begins here and takes 8 s, so that lost samples cost the heading."""
NAVIGATING = 3
DEGRADED = 4


@dataclass(frozen=True)
class Drive:
    """A finished run, with its solutions as plain arrays."""

    result: RunResult

    def column(self, name: str) -> NDArray[np.float64]:
        """A column of the solutions that the host received."""
        assert self.result.data is not None
        return self.result.data.solution.column(name)

    @property
    def t(self) -> NDArray[np.float64]:
        """Times of the solutions."""
        return self.column("t_s")

    @property
    def horizontal_error(self) -> NDArray[np.float64]:
        """Horizontal position error in m; infinite while the board does not navigate."""
        error = np.hypot(self.column("error_north_m"), self.column("error_east_m"))
        return np.where(self.column("mode") >= NAVIGATING, error, np.inf)

    def worst(self, from_s: float, to_s: float = np.inf) -> float:
        """Largest horizontal error between two times."""
        chosen = (self.t >= from_s) & (self.t <= to_s)
        return float(np.max(self.horizontal_error[chosen], initial=0.0))

    def modes(self, from_s: float = 0.0, to_s: float = np.inf) -> set[int]:
        """Modes met between two times."""
        return set(self.column("mode")[(self.t >= from_s) & (self.t <= to_s)].astype(int).tolist())

    def said(self, words: str, from_s: float = 0.0) -> bool:
        """Whether the board said it, from a time on."""
        return any(
            words in event.text and event.at_s >= from_s and event.source == "board"
            for event in self.result.events
        )

    def texts(self) -> str:
        """All events, a line each."""
        return "\n".join(f"{event.at_s:.1f} s {event.source}: {event.text}" for event in self.result.events)

    def good_after(self, error_m: float, from_s: float) -> float:
        """Seconds from `from_s` until the error stays below `error_m` and solutions come without a gap."""
        t = self.t
        bad = t[(t >= from_s) & (self.horizontal_error > error_m)]
        gap_ends = t[1:][(np.diff(t) > 0.5) & (t[1:] > from_s)]
        return max([0.0, *(bad[-1:] - from_s), *(gap_ends[-1:] - from_s)])


@functools.cache
def drive(*overrides: str, profile: str | None = None, seed: int = 1) -> Drive:
    """Drive the short drive on the car_mems board."""
    return Drive(run(RunRequest("car_mems", str(SHORT_DRIVE), profile, seed, overrides)))


def broken(
    kind: str, target: str, at_s: float = FAULT_AT_S, duration_s: float | None = 5.0, **parameters: object
) -> str:
    """A fault as an override."""
    lasting = "" if duration_s is None else f", duration_s = {duration_s}"
    values = ", ".join(f"{key} = {_toml(value)}" for key, value in parameters.items())
    where = f'kind = "{kind}", target = "{target}", at_s = {at_s}{lasting}'
    return f"fault=[{{ {where}, parameters = {{ {values} }} }}]"


def _toml(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    return str(value).lower() if isinstance(value, bool) else repr(value)
