"""What a time without GNSS costs: the error at the end of each outage that the scenario declares."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

import numpy as np

from host.record.result import Outage
from host.score.window import RecentRows


class OutageWatch:
    """Waits for the ends of the outages and notes the solution's error there."""

    def __init__(self, outages: Sequence[tuple[float, float]]) -> None:
        self._instants = sorted(
            {start for start, _ in outages} | {start + duration for start, duration in outages}
        )
        self._outages = sorted(outages)
        self._errors: dict[float, tuple[float | None, float | None]] = {}

    def judge(self, until: float, recent: RecentRows) -> None:
        """Note the errors at all starts and ends up to `until`."""
        while self._instants and self._instants[0] <= until:
            t = self._instants.pop(0)
            north, east, down = recent.at(np.array([t]))[0, :3].tolist()
            there = math.isfinite(north)
            self._errors[t] = (math.hypot(north, east), abs(down)) if there else (None, None)

    def finished(self) -> tuple[Outage, ...]:
        """All declared outages; without a drift where no solution was heard at the end."""
        nothing = (None, None)
        found = []
        for start, duration in self._outages:
            horizontal, vertical = self._errors.get(start + duration, nothing)
            at_start, _ = self._errors.get(start, nothing)
            found.append(Outage(start, duration, horizontal, at_start, vertical))
        return tuple(found)

    @staticmethod
    def figures(outages: Sequence[Outage]) -> dict[str, float | None]:
        """Median and maximum of the drifts; None when there is no outage or one of them has no drift."""
        drifts = [outage.horizontal_drift_m for outage in outages]
        known = [drift for drift in drifts if drift is not None]
        whole = bool(known) and len(known) == len(drifts)
        return {
            "outage_horizontal_drift_median_m": median(known) if whole else None,
            "outage_horizontal_drift_max_m": max(known) if whole else None,
        }
