"""Is one figure worse than it was? Runs of one seed are compared, so that the noise they share falls out.

*Worse*: the mean difference exceeds the tolerance times the baseline's mean, and either its 95 % interval
(Student's t on the paired differences) lies wholly on the bad side of zero, or every single pair is worse by
more than the tolerance. *Unsure*: beyond the tolerance, but neither of the two: more seeds would tell. A
figure that was zero in all runs of the baseline is worse with any increase, a figure that cannot be computed
any more and a run that no longer reaches its end are worse always.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.baseline.file import BaselineRun
from host.baseline.gated import DID_NOT_FINISH, direction
from host.campaign.statistics import mean_interval

ROUNDING = 1e-9
"""Relative difference below which two figures are the same."""
WORSE, UNSURE, BETTER = "worse", "unsure", "better"

Pair = tuple[BaselineRun, BaselineRun]
"""The run of the baseline, and the one of now with the same set-up and seed."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One figure of one set-up, over the seeds that both have."""

    setup: str
    figure: str
    runs: int
    baseline: float | None
    now: float | None
    low: float | None
    """Interval of the mean difference now − baseline; None with fewer than two runs."""
    high: float | None
    verdict: str
    """WORSE, UNSURE, BETTER or nothing."""


def differences(setup: str, pairs: Sequence[Pair], tolerance: float) -> list[Difference]:
    """Whether the runs reached their ends, then every figure of the pairs of which both did."""
    finished = [pair for pair in pairs if not any(run.figures[DID_NOT_FINISH] for run in pair)]
    names = dict.fromkeys(name for old, _ in finished for name in old.figures if direction(name))
    names.pop(DID_NOT_FINISH, None)
    made = [_difference(setup, DID_NOT_FINISH, pairs, 0.0)]
    return made + [_difference(setup, name, finished, tolerance) for name in names]


def _difference(setup: str, name: str, pairs: Sequence[Pair], tolerance: float) -> Difference:
    both = [(old.figures.get(name), new.figures.get(name)) for old, new in pairs]
    values = np.array([pair for pair in both if None not in pair], dtype=np.float64).reshape(-1, 2)
    old, new = values.T
    base = float(old.mean()) if len(old) else None
    if any(before is not None and now is None for before, now in both):
        return Difference(setup, name, len(old), base, None, None, None, WORSE)
    if base is None:
        return Difference(setup, name, 0, None, None, None, None, "")
    low = high = None
    if len(old) > 1:
        changes = new - old
        low, high = mean_interval(float(changes.mean()), float(changes.std(ddof=1)), len(old))
    verdict = _verdict(name, old, new, tolerance, low, high)
    return Difference(setup, name, len(old), base, float(new.mean()), low, high, verdict)


def _verdict(
    name: str,
    old: NDArray[np.float64],
    new: NDArray[np.float64],
    tolerance: float,
    low: float | None,
    high: float | None,
) -> str:
    sign = direction(name)
    worsened = sign * (new - old)
    mean = worsened.mean()
    if name == DID_NOT_FINISH and (worsened > 0).any():
        return WORSE
    if not old.any() and mean > 0:
        return WORSE
    sure_worse = sure_better = len(old) == 1
    if low is not None and high is not None:
        sure_worse, sure_better = min(sign * low, sign * high) > 0, max(sign * low, sign * high) < 0
    share = tolerance + ROUNDING
    allowed = share * abs(old.mean())
    if mean > allowed:
        return WORSE if sure_worse or (worsened > share * np.abs(old)).all() else UNSURE
    return BETTER if -mean > allowed and sure_better else ""
