"""Expectations of a scenario: a figure of the run and the limit it must keep.

Names are the keys of `metrics` (with or without "metrics." in front), of `gnss` after "gnss.", and of
processors, buses and faults as `cpu.<name>.load`, `cpu.<name>.deadline_misses`, `buses.<name>.load`,
`faults.<name>.fired`; `deadline_misses` and `overruns` count over all processors, `faults_not_fired` the
faults that never struck. A limit is a number or another figure of the same run. A figure that could not be
computed meets no expectation.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

from host.record.errors import UserError, did_you_mean
from host.record.result import BusUse, CpuUse, Expectation, FaultUse
from host.score.scorer import Scorer

PER_PART = {
    "cpu": ("load", "deadline_misses", "overruns", "resets", "stack_worst_bytes"),
    "buses": ("load", "transactions", "errors"),
    "faults": ("fired",),
}


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
    expect: Mapping[str, Limit], parts: Mapping[str, Iterable[str]] | None = None, source: str = "expect"
) -> None:
    """Tell before a run that a scenario expects a figure that does not exist, by UserError.

    `parts` names what the run has, e.g. {"cpu": ["mcu"], "buses": ["spi1"], "faults": ["cable"]}.
    """
    empty = Scorer().result(0.0)
    known = set(flat_figures(empty.metrics, empty.gnss))
    for head, names in (parts or {}).items():
        known |= {f"{head}.{name}.{figure}" for name in names for figure in PER_PART[head]}
    for name, limit in expect.items():
        for figure in (name, limit.name):
            if figure is not None and bare(figure) not in known:
                hint = did_you_mean(bare(figure), known)
                raise UserError(f"{source}: [expect] {name}: no figure named {figure!r}; {hint}")


def bare(name: str) -> str:
    """The name of a figure without "metrics." in front."""
    return name.removeprefix("metrics.")


def flat_figures(
    metrics: Mapping[str, float | None],
    gnss: Mapping[str, float | None],
    cpu: Sequence[CpuUse] = (),
    buses: Sequence[BusUse] = (),
    faults: Sequence[FaultUse] = (),
) -> dict[str, float | None]:
    """All figures of a run by the names that expectations use."""
    found = dict(metrics) | {f"gnss.{name}": value for name, value in gnss.items()}
    for head, parts in (("cpu", cpu), ("buses", buses), ("faults", faults)):
        for part in parts:
            for figure in PER_PART[head]:
                found[f"{head}.{part.name}.{figure}"] = float(getattr(part, figure))
    found["deadline_misses"] = float(sum(processor.deadline_misses for processor in cpu))
    found["overruns"] = float(sum(processor.overruns for processor in cpu))
    found["faults_not_fired"] = float(sum(fault.fired == 0 for fault in faults))
    return found


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
