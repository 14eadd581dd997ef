"""Expectations of a scenario: a figure of the run and the limit it must keep.

Names are the keys of `metrics` (with or without "metrics." in front), of `gnss` after "gnss.", and of
processors, buses and faults as `cpu.<name>.load`, `cpu.<name>.deadline_misses`, `buses.<name>.load`,
`faults.<name>.fired`; `deadline_misses` and `overruns` count over all processors, `faults_not_fired` the
faults that never struck; `recording.fused.after_position_horizontal_rms_m` and the like are what the fit of a
recording tells (`host.score.recording_fit`). A limit is a number or another figure of the same run. A figure
that could not be computed meets no expectation. That there was a navigation solution is expected with all
others, unless they speak of that themselves (`NAVIGATION`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from boards.hints import did_you_mean
from host.record.errors import UserError
from host.record.result import BusUse, CpuUse, Expectation, FaultUse
from host.score.ages import AGE_FIGURES
from host.score.recording_fit import FIGURES
from host.score.scorer import Scorer

PER_PART = {
    "cpu": ("load", "deadline_misses", "overruns", "resets", "stack_worst_bytes"),
    "buses": ("load", "transactions", "errors"),
    "faults": ("fired",),
}


NAVIGATION = ("seconds_with_solution", "availability", "aligned_at_s", "epochs", "epochs_without_solution")
"""Who expects something of these has thought of a run without a solution."""


class Limit(Protocol):
    """What a figure must satisfy: `relation` ("<=" or ">=") to `value`, or to the figure called `name`."""

    @property
    def relation(self) -> str:
        """ "<=" or ">="."""
        ...

    @property
    def value(self) -> float | None:
        """The limit; None when `name` tells it."""
        ...

    @property
    def name(self) -> str | None:
        """The figure that is the limit, e.g. "gnss.position_horizontal_rms_m"."""
        ...


def check_names(
    expect: Mapping[str, Limit],
    parts: Mapping[str, Iterable[str]] | None = None,
    source: str = "expect",
    recording: bool = False,
) -> None:
    """Tell before a run that a scenario expects a figure that does not exist, by UserError.

    `parts` names what the run has, e.g. {"cpu": ["mcu"], "buses": ["spi1"], "faults": ["cable"]};
    `recording`: whether it is scored against the reference of a recording.
    """
    empty = Scorer().result(0.0)
    known = {*flat_figures(empty.metrics, empty.gnss), *AGE_FIGURES}
    if recording:
        known |= {f"recording.{figure}" for figure in FIGURES}
    for head, names in (parts or {}).items():
        known |= {f"{head}.{name}.{figure}" for name in names for figure in PER_PART[head]}
    for name, limit in expect.items():
        for figure in (name, limit.name):
            if figure is not None and bare(figure) not in known:
                hint = did_you_mean(bare(figure), known)
                raise UserError(f"{source}: [expect] {name}: no figure named {figure!r}; {hint}")


@dataclass(frozen=True, slots=True)
class AtLeast:
    """A lower limit."""

    value: float
    relation: str = ">="
    name: str | None = None


def with_solution_demanded(expect: Mapping[str, Limit]) -> dict[str, Limit]:
    """The expectations, and that there was a navigation solution at all unless they speak of that."""
    if not expect or any(bare(name) in NAVIGATION for name in expect):
        return dict(expect)
    return {**expect, "seconds_with_solution": AtLeast(1.0)}


def bare(name: str) -> str:
    """The name of a figure without "metrics." in front."""
    return name.removeprefix("metrics.")


def flat_figures(
    metrics: Mapping[str, float | None],
    gnss: Mapping[str, float | None],
    cpu: Sequence[CpuUse] = (),
    buses: Sequence[BusUse] = (),
    faults: Sequence[FaultUse] = (),
    recording: Mapping[str, Any] | None = None,
) -> dict[str, float | None]:
    """All figures of a run by the names that expectations use."""
    found = dict(metrics) | {f"gnss.{name}": value for name, value in gnss.items()}
    found |= {f"recording.{figure}": _deep(recording, figure) for figure in FIGURES if recording}
    for head, parts in (("cpu", cpu), ("buses", buses), ("faults", faults)):
        for part in parts:
            for figure in PER_PART[head]:
                found[f"{head}.{part.name}.{figure}"] = float(getattr(part, figure))
    found["deadline_misses"] = float(sum(processor.deadline_misses for processor in cpu))
    found["overruns"] = float(sum(processor.overruns for processor in cpu))
    found["faults_not_fired"] = float(sum(fault.fired == 0 for fault in faults))
    return found


def _deep(tables: Any, path: str) -> float | None:
    for key in path.split("."):
        tables = tables.get(key) if tables is not None else None
    return None if tables is None else float(tables)


def judge(expect: Mapping[str, Limit], figures: Mapping[str, float | None]) -> tuple[Expectation, ...]:
    """Hold the figures of a run against the limits, in their order."""
    return tuple(_judge_one(bare(name), limit, figures) for name, limit in expect.items())


def _judge_one(name: str, limit: Limit, figures: Mapping[str, float | None]) -> Expectation:
    value = figures.get(name)
    bound = limit.value if limit.name is None else figures.get(bare(limit.name))
    ok = False
    if value is not None and bound is not None:
        ok = value <= bound if limit.relation == "<=" else value >= bound
    return Expectation(name, value, limit.relation, bound, ok, limit.name)
