"""What has become worse than the baseline, with confidence.

Figures are compared run by run over common seeds: the noise that both share falls out of the difference. A
figure is *worse* when its mean difference exceeds the tolerance times the baseline's mean and the 95 %
interval of the paired difference (Student's t) lies wholly on the bad side of zero. With a single common run
there is no interval; the tolerance alone decides.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from host.baseline.file import Baseline, BaselineRun, scenario_digest
from host.baseline.gated import DID_NOT_FINISH, direction
from host.campaign.statistics import mean_interval
from host.record.errors import UserError
from host.report.numbers import NONE, number
from host.report.summary import Section

ROUNDING = 1e-9
"""Relative difference below which two figures are the same."""
WORSE, BETTER = "worse", "better"


@dataclass(frozen=True, slots=True)
class Difference:
    """One figure of one set-up, over the seeds that both have."""

    setup: str
    figure: str
    runs: int
    baseline: float | None
    now: float | None
    low: float | None
    """Interval of the mean difference now − baseline."""
    high: float | None
    verdict: str
    """"worse", "better" or nothing."""


@dataclass(frozen=True)
class Comparison:
    """All figures, against one baseline."""

    baseline: Baseline
    tolerance: float
    differences: tuple[Difference, ...]
    runs: int

    @property
    def ok(self) -> bool:
        """Nothing has become worse."""
        return not self.worse

    @property
    def worse(self) -> list[Difference]:
        """What has."""
        return [one for one in self.differences if one.verdict == WORSE]

    def verdict(self) -> str:
        """One line."""
        base = f"the baseline {self.baseline.path} (tolerance {100 * self.tolerance:g} %, {self.runs} runs)"
        better = sum(one.verdict == BETTER for one in self.differences)
        if self.ok:
            return f"nothing is worse than {base}; {better} figures are better"
        return f"{len(self.worse)} figures are WORSE than {base}"

    def section(self) -> Section:
        """What has become worse, then what has become better."""
        told = sorted((one for one in self.differences if one.verdict), key=lambda one: one.verdict != WORSE)
        rows = tuple(
            (
                one.setup,
                one.figure,
                number(one.baseline),
                number(one.now),
                _change(one),
                _interval(one),
                one.verdict.upper() if one.verdict == WORSE else one.verdict,
            )
            for one in told
        )
        columns = ("set-up", "figure", "baseline", "now", "change", "95 % of the difference", "verdict")
        note = f"{self.verdict()}; means over common seeds"
        return Section("Against the baseline", columns, rows, words=2, note=note)

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "file": str(self.baseline.path),
            "tolerance": self.tolerance,
            "ok": self.ok,
            "runs": self.runs,
            "worse": [asdict(one) for one in self.worse],
            "better": [asdict(one) for one in self.differences if one.verdict == BETTER],
        }


def compared(
    baseline: Baseline, runs: Sequence[BaselineRun], manifest: Mapping[str, Any], tolerance: float
) -> Comparison:
    """Hold runs against a baseline. Raises UserError when it is not one for them."""
    must_fit(baseline, manifest)
    before = {(one.setup, one.seed): one for one in baseline.runs}
    pairs: dict[tuple[str, tuple[tuple[str, str], ...]], list[tuple[BaselineRun, BaselineRun]]] = {}
    for run in runs:
        old = before.get((run.setup, run.seed))
        if old is not None:
            pairs.setdefault(run.setup, []).append((old, run))
    if not pairs:
        have = sorted({f"{one.profile} seed {one.seed}" for one in baseline.runs})[:5]
        raise UserError(f"--baseline {baseline.path}: has no run in common; it has {', '.join(have)} …")
    found = [_of_setup(_label(setup), both, tolerance) for setup, both in pairs.items()]
    return Comparison(baseline, tolerance, tuple(itertools.chain(*found)), sum(map(len, pairs.values())))


def must_fit(baseline: Baseline, manifest: Mapping[str, Any]) -> None:
    """Raises UserError when board, scenario or changes of the baseline are others."""
    asked = {
        "board": manifest["board"],
        "scenario": manifest["scenario"],
        "scenario_digest": scenario_digest(manifest),
        "overrides": tuple(manifest["overrides"]),
    }
    for name, value in asked.items():
        have = getattr(baseline, name)
        if have != value:
            what = "the text of the scenario" if name == "scenario_digest" else name
            raise UserError(
                f"--baseline {baseline.path}: was made with another {what} ({have!r}, now {value!r});"
                f" make it anew: navtwin baseline update {baseline.path} runs/FOLDER"
            )


def _label(setup: tuple[str, tuple[tuple[str, str], ...]]) -> str:
    return " ".join([setup[0], *(f"{key}={value}" for key, value in setup[1])])


def _of_setup(
    setup: str, pairs: Sequence[tuple[BaselineRun, BaselineRun]], tolerance: float
) -> list[Difference]:
    finished = [pair for pair in pairs if not pair[1].figures[DID_NOT_FINISH]]
    names = [name for name in pairs[0][0].figures if name != DID_NOT_FINISH]
    made = [_compare(setup, DID_NOT_FINISH, pairs, 0.0)]
    return made + [_compare(setup, name, finished, tolerance) for name in names if finished]


def _compare(
    setup: str, name: str, pairs: Sequence[tuple[BaselineRun, BaselineRun]], tolerance: float
) -> Difference:
    both = [(old.figures.get(name), new.figures.get(name)) for old, new in pairs]
    lost = sum(old is not None and new is None for old, new in both)
    values = np.array([(old, new) for old, new in both if old is not None and new is not None], dtype=float)
    if lost:
        base = float(values[:, 0].mean()) if len(values) else None
        return Difference(setup, name, len(values), base, None, None, None, WORSE)
    if len(values) == 0:
        return Difference(setup, name, 0, None, None, None, None, "")
    base, now = values.mean(axis=0).tolist()
    differences = values[:, 1] - values[:, 0]
    mean = float(differences.mean())
    low = high = None
    if len(values) > 1:
        low, high = mean_interval(mean, float(differences.std(ddof=1)), len(values))
    sign = direction(name)
    sure_low, sure_high = (mean, mean) if low is None or high is None else (low, high)
    allowed = tolerance * abs(base) + ROUNDING * abs(base)
    verdict = ""
    if sign * mean > allowed and min(sign * sure_low, sign * sure_high) > 0:
        verdict = WORSE
    elif -sign * mean > allowed and max(sign * sure_low, sign * sure_high) < 0:
        verdict = BETTER
    return Difference(setup, name, len(values), base, now, low, high, verdict)


def _change(one: Difference) -> str:
    if one.now is None or one.baseline is None:
        return "no figure any more"
    if one.baseline == 0:
        return f"{one.now - one.baseline:+g}"
    return f"{100 * (one.now - one.baseline) / abs(one.baseline):+.1f} %"


def _interval(one: Difference) -> str:
    return NONE if one.low is None else f"{number(one.low)} … {number(one.high)}"
