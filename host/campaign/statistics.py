"""What many runs say together: mean, median, spread, confidence; and the bounds of consistent filters.

Confidence interval of a mean: Student's t on the spread between runs, which are independent since each seed
draws all noise anew. Average NEES over N runs: N·mean is χ² with N·n degrees of freedom when the filter is
honest (Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and Navigation*, section
5.4.2); likewise a squared normalised innovation with n = 1.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.campaign.row import FINISHED, Value

CONFIDENCE = 0.95
NOT_FIGURES = ("run", "seed", "duration_s")


@dataclass(frozen=True, slots=True)
class Spread:
    """One figure over all runs of a set-up. The interval is of the mean; None with fewer than two runs."""

    count: int
    mean: float
    median: float
    p95: float
    minimum: float
    maximum: float
    deviation: float | None
    low: float | None
    high: float | None

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def spread(values: Sequence[float]) -> Spread:
    """Of at least one value."""
    taken = np.asarray(values, dtype=np.float64)
    low = high = deviation = None
    mean = float(taken.mean())
    if len(taken) > 1:
        deviation = float(taken.std(ddof=1))
        low, high = mean_interval(mean, deviation, len(taken))
    return Spread(
        count=len(taken),
        mean=mean,
        median=float(np.median(taken)),
        p95=float(np.quantile(taken, 0.95)),
        minimum=float(taken.min()),
        maximum=float(taken.max()),
        deviation=deviation,
        low=low,
        high=high,
    )


def mean_interval(mean: float, deviation: float, count: int) -> tuple[float, float]:
    """Student's confidence interval of a mean of `count` > 1 independent values."""
    from scipy.special import stdtrit

    half = float(stdtrit(count - 1, (1 + CONFIDENCE) / 2)) * deviation / math.sqrt(count)
    return mean - half, mean + half


def mean_square_bounds(dimension: int, runs: int) -> tuple[float, float]:
    """Between which the mean over `runs` of a χ² variable with `dimension` lies with CONFIDENCE."""
    from scipy.special import chdtri

    freedom = dimension * runs
    share = (1 - CONFIDENCE) / 2
    return float(chdtri(freedom, 1 - share)) / runs, float(chdtri(freedom, share)) / runs


def figures(rows: Iterable[Mapping[str, Value]]) -> dict[str, Spread]:
    """Every numeric column of the runs that reached their end, in the order of the columns."""
    values: dict[str, list[float]] = {}
    for row in rows:
        if row["status"] != FINISHED:
            continue
        for name, value in row.items():
            numeric = isinstance(value, int | float) and not isinstance(value, bool)
            if numeric and name not in NOT_FIGURES and not name.startswith(("set.", "expect.")):
                assert isinstance(value, int | float)
                values.setdefault(name, []).append(float(value))
    return {name: spread(found) for name, found in values.items()}


def rms(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Root mean square over runs (rows), NaN left out; NaN where there is none."""
    return np.sqrt(nan_mean(values**2))


def nan_mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean over runs (rows), NaN left out; NaN where there is none."""
    there = np.isfinite(values)
    count = there.sum(axis=0)
    total = np.where(there, values, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
