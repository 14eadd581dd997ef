"""What has become worse than the baseline: runs in pairs of the same set-up and seed, told as a table.

How one figure is judged: `host.baseline.judging`. What could not be compared is said.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from host.baseline.file import Baseline, BaselineRun, SetupKey, scenario_digest
from host.baseline.gated import DID_NOT_FINISH
from host.baseline.judging import BETTER, UNSURE, WORSE, Difference, Pair, differences
from host.record.errors import UserError
from host.report.numbers import NONE, number
from host.report.summary import Section

TOLD_FIRST = (WORSE, UNSURE, BETTER)
NAMES_SHOWN = 5


@dataclass(frozen=True)
class Comparison:
    """All figures, against one baseline."""

    baseline: Baseline
    tolerance: float
    differences: tuple[Difference, ...]
    runs: int
    """Runs that both have."""
    left_out: tuple[str, ...] = ()
    """What only one of the two has, in words."""

    @property
    def ok(self) -> bool:
        """Nothing has become worse for sure."""
        return not self.worse

    @property
    def worse(self) -> list[Difference]:
        """What has become worse."""
        return self._judged(WORSE)

    @property
    def unsure(self) -> list[Difference]:
        """What is beyond the tolerance, but may be chance."""
        return self._judged(UNSURE)

    def verdict(self) -> str:
        """One line."""
        runs = _counted(self.runs, "run")
        base = f"the baseline {self.baseline.path} (tolerance {100 * self.tolerance:g} %, {runs})"
        more = "may be worse, within the interval: run more seeds"
        unsure = _counted(len(self.unsure), "figure")
        if self.worse:
            told = f"{_are(len(self.worse))} WORSE than {base}" + (
                f"; {unsure} {more}" if self.unsure else ""
            )
        elif self.unsure:
            told = f"against {base} {unsure} {more}"
        else:
            told = f"nothing is worse than {base}; {_are(len(self._judged(BETTER)))} better"
        return "; ".join((told, *self.left_out))

    def section(self) -> Section:
        """What has become worse, what may have, then what has become better."""
        told = sorted(
            (one for one in self.differences if one.verdict), key=lambda one: TOLD_FIRST.index(one.verdict)
        )
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
            "left_out": list(self.left_out),
            **{kind: [asdict(one) for one in self._judged(kind)] for kind in TOLD_FIRST},
        }

    def _judged(self, verdict: str) -> list[Difference]:
        return [one for one in self.differences if one.verdict == verdict]


def compared(
    baseline: Baseline, runs: Sequence[BaselineRun], manifest: Mapping[str, Any], tolerance: float
) -> Comparison:
    """Hold runs against a baseline. Raises UserError when it is not one for them."""
    must_fit(baseline, manifest)
    before = {(one.setup, one.seed): one for one in baseline.runs}
    pairs: dict[SetupKey, list[Pair]] = {}
    for run in runs:
        old = before.get((run.setup, run.seed))
        if old is not None:
            pairs.setdefault(run.setup, []).append((old, run))
    if not pairs:
        raise UserError(f"--baseline {baseline.path}: has no run in common; {_what_it_has(baseline)}")
    found = [differences(_label(setup), both, tolerance) for setup, both in pairs.items()]
    left_out = (*_unpaired_setups(baseline, runs), *_unknown_figures(pairs))
    return Comparison(
        baseline, tolerance, tuple(itertools.chain(*found)), sum(map(len, pairs.values())), left_out
    )


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


def _unpaired_setups(baseline: Baseline, runs: Sequence[BaselineRun]) -> list[str]:
    there = dict.fromkeys(one.setup for one in baseline.runs)
    here = dict.fromkeys(one.setup for one in runs)
    return [
        f"{what}: {_listed([_label(setup) for setup in some if setup not in others])}"
        for what, some, others in (
            ("in the baseline but not run", there, here),
            ("run but not in the baseline", here, there),
        )
        if any(setup not in others for setup in some)
    ]


def _unknown_figures(pairs: Mapping[SetupKey, Sequence[Pair]]) -> list[str]:
    """Figures that would be compared, were they in the baseline."""
    reached_ends = [pair for both in pairs.values() for pair in both if not pair[0].figures[DID_NOT_FINISH]]
    known = {name for old, _ in reached_ends for name in _computed(old)}
    now = dict.fromkeys(name for _, run in reached_ends for name in _computed(run))
    lacking = [name for name in now if name not in known]
    return [f"not compared, since the baseline lacks them: {_listed(lacking)}"] if lacking else []


def _computed(run: BaselineRun) -> list[str]:
    return [name for name, value in run.figures.items() if value is not None]


def _what_it_has(baseline: Baseline) -> str:
    have = sorted({(one.profile, one.seed) for one in baseline.runs})
    return f"it has {_listed([f'{profile} seed {seed}' for profile, seed in have])}"


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(names[:NAMES_SHOWN]) or "no runs"
    return shown if len(names) <= NAMES_SHOWN else f"{shown} … ({len(names)} in all)"


def _label(setup: SetupKey) -> str:
    return " ".join([setup[0], *(f"{key}={value}" for key, value in setup[1])])


def _counted(count: int, what: str) -> str:
    return f"1 {what}" if count == 1 else f"{count} {what}s"


def _are(count: int) -> str:
    return f"{_counted(count, 'figure')} {'is' if count == 1 else 'are'}"


def _change(one: Difference) -> str:
    if one.now is None or one.baseline is None:
        return "no figure any more"
    if one.baseline == 0:
        return f"{one.now - one.baseline:+g}"
    return f"{100 * (one.now - one.baseline) / abs(one.baseline):+.1f} %"


def _interval(one: Difference) -> str:
    return NONE if one.low is None else f"{number(one.low)} … {number(one.high)}"
