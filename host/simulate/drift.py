"""What outages did: errors along one drive or several, and what figure they make together."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.campaign.statistics import mean_interval
from host.sim.gnss.schedule import Window, window

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Plan:
    """When there is no receiver."""

    outages: int = 20
    length_s: int = 60
    gap_s: int = 540
    """Between outages, with a receiver."""
    settle_s: int = 300
    """Before the first one."""

    @property
    def starts_s(self) -> tuple[int, ...]:
        """Of each outage."""
        return tuple(self.settle_s + k * (self.length_s + self.gap_s) for k in range(self.outages))

    @property
    def duration_s(self) -> int:
        """Of the drive: a second beyond the last outage."""
        return self.starts_s[-1] + self.length_s + 1

    def windows(self) -> list[Window]:
        """Without the receiver's epochs, the one at their very end too."""
        return [window(start, self.length_s + 0.5) for start in self.starts_s]


@dataclass(frozen=True, slots=True)
class Drift:
    """What one sensor did on several drives: errors each second, estimated minus true."""

    preset: str
    seeds: tuple[int, ...]
    """One for each drive, on which everything that is drawn is drawn anew."""
    t_s: Floats
    errors: Floats
    """(drives, n, 6): north, east, down in m; roll, pitch, yaw in °."""
    claimed_m: Floats
    """(drives, n): horizontal 1 σ by the filter's own covariance."""
    plan: Plan

    def rows(self, after_s: int) -> NDArray[np.int64]:
        """Where the seconds `after_s` after each outage's beginning stand."""
        return np.searchsorted(self.t_s, [start + after_s for start in self.plan.starts_s])

    def horizontal_m(self) -> Floats:
        """(drives · outages, length + 1): horizontal error each second of each outage."""
        grid = np.array([self.rows(after) for after in range(self.plan.length_s + 1)]).T
        sizes: Floats = np.hypot(self.errors[:, grid, 0], self.errors[:, grid, 1])
        return sizes.reshape(-1, self.plan.length_s + 1)

    def horizontal_rms_m(self) -> float:
        """Over the ends of all outages of all drives."""
        return _rms(self.horizontal_m()[:, -1])

    def each_rms_m(self) -> list[float]:
        """Of each drive."""
        return [_rms(ends) for ends in self.horizontal_m()[:, -1].reshape(len(self.seeds), -1)]

    def interval_m(self) -> tuple[float, float] | None:
        """The 95 % interval of what `horizontal_rms_m` would be over endless drives, by how the drives' mean
        squares scatter (Student's t, on their logarithm's scale); None for a single drive."""
        squares = np.square(self.each_rms_m())
        if len(squares) < 2:
            return None
        mean = float(squares.mean())
        low, high = mean_interval(0.0, float(squares.std(ddof=1)) / mean if mean else 0.0, len(squares))
        found = self.horizontal_rms_m()
        return found * math.exp(low / 2.0), found * math.exp(high / 2.0)

    def claimed_rms_m(self) -> float:
        """What the filter expects that to be."""
        return _rms(self.claimed_m[:, self.rows(self.plan.length_s)])

    def rms(self, column: int) -> float:
        """Of one column of `errors` over the ends."""
        return _rms(self.errors[:, self.rows(self.plan.length_s), column])


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
