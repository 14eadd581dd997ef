"""The summary of a campaign: verdict, spread of every figure by set-up, and the filter's honesty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from host.campaign.campaign import Finished
from host.campaign.plan import Setup
from host.campaign.row import FINISHED, Value
from host.campaign.statistics import Spread, figures

SUMMARY_FORMAT = "navtwin-campaign-summary-1"


@dataclass(frozen=True)
class SetupSummary:
    """All runs of one set-up."""

    setup: Setup
    runs: int
    failed: int
    met: int
    """Runs that met every expectation."""
    figures: dict[str, Spread]
    expectations: dict[str, int]
    """For each expectation how many runs met it."""
    rows: tuple[Mapping[str, Value], ...] = ()

    def by_seed(self, name: str) -> dict[int, float]:
        """One figure of the runs that have it."""
        found = {row["seed"]: row.get(name) for row in self.rows if row["status"] == FINISHED}
        return {int(seed): float(value) for seed, value in found.items() if value is not None}  # type: ignore[arg-type]


@dataclass(frozen=True)
class Summary:
    """All runs of a campaign."""

    setups: tuple[SetupSummary, ...]
    failures: tuple[tuple[str, str], ...]
    """(run, error) of the runs that did not reach their end."""

    @property
    def runs(self) -> int:
        """How many runs there were."""
        return sum(one.runs for one in self.setups)

    @property
    def met(self) -> int:
        """How many of them met every expectation."""
        return sum(one.met for one in self.setups)

    def ok(self, share: float) -> bool:
        """Whether that share of the runs, of each set-up, met every expectation."""
        return all(one.met >= share * one.runs for one in self.setups)

    def to_dict(self, manifest: Mapping[str, Any], share: float) -> dict[str, Any]:
        """The stable JSON object of `--json`. No wall-clock figure: it repeats byte for byte."""
        told = ("board", "scenario", "kind", "profiles", "seeds", "swept", "overrides", "versions", "sources")
        return {
            "format": SUMMARY_FORMAT,
            **{key: manifest[key] for key in told},
            "runs": self.runs,
            "failed": len(self.failures),
            "met": self.met,
            "ok": self.ok(share),
            "setups": [_setup_dict(one) for one in self.setups],
            "failures": [{"run": run, "error": error} for run, error in self.failures],
        }


def summarised(finished: Finished) -> Summary:
    """The summary of all runs that there are."""
    by_setup: dict[Setup, list[Mapping[str, Value]]] = {setup: [] for setup in finished.plan.setups()}
    by_number = {outcome.number: outcome for outcome in finished.outcomes}
    failures = []
    for job in finished.plan.jobs():
        outcome = by_number.get(job.number)
        if outcome is None:
            continue
        by_setup[job.setup].append(outcome.row)
        if outcome.row["status"] != FINISHED:
            failures.append((job.key, str(outcome.row["error"])))
    return Summary(tuple(_of_setup(setup, rows) for setup, rows in by_setup.items()), tuple(failures))


def _of_setup(setup: Setup, rows: Sequence[Mapping[str, Value]]) -> SetupSummary:
    expectations: dict[str, int] = {}
    for row in rows:
        for name, value in row.items():
            if name.startswith("expect.") and name.endswith(".met"):
                short = name.removeprefix("expect.").removesuffix(".met")
                expectations[short] = expectations.get(short, 0) + bool(value)
    return SetupSummary(
        setup=setup,
        runs=len(rows),
        failed=sum(row["status"] != FINISHED for row in rows),
        met=sum(bool(row["met"]) for row in rows),
        figures=figures(rows),
        expectations=expectations,
        rows=tuple(rows),
    )


def _setup_dict(one: SetupSummary) -> dict[str, Any]:
    return {
        "profile": one.setup.profile,
        "set": dict(one.setup.swept),
        "runs": one.runs,
        "failed": one.failed,
        "met": one.met,
        "expectations": one.expectations,
        "figures": {name: value.to_dict() for name, value in one.figures.items()},
    }
