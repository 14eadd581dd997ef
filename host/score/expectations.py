"""Expectations of a scenario: a figure of the run and the limit it must keep.

A scenario writes them as `name = limit`:

    position_horizontal_rms_m = "<= gnss.position_horizontal_rms_m"   # another figure as the limit
    velocity_rms_mps = 0.1                                            # a bare number: at most
    nees_mean = "4.5 .. 18"                                           # a range
    availability = ">= 0.99"

Names are the keys of `metrics` as they are, of `gnss` after "gnss.", and of processors, buses and faults as
`cpu.<name>.load`, `cpu.<name>.deadline_misses`, `buses.<name>.load`, `faults.<name>.fired`; `deadline_misses`
and `overruns` count over all processors, `faults_not_fired` the faults that never struck. A bare number is
the most that is allowed; for figures of which more is better (`availability`, `gnss.fix_share`, `epochs`,
`faults.<name>.fired`) the least. A figure that could not be computed meets no expectation.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from host.record.errors import UserError, did_you_mean
from host.record.result import BusUse, CpuUse, Expectation, FaultUse
from host.score.scorer import Scorer

MORE_IS_BETTER = ("availability", "gnss.fix_share", "epochs", "nees_epochs")
PER_PART = {
    "cpu": ("load", "deadline_misses", "overruns", "resets", "stack_worst_bytes"),
    "buses": ("load", "transactions", "errors"),
    "faults": ("fired",),
}

_NUMBER = r"[-+]?\d+(?:_?\d)*(?:\.\d+)?(?:[eE][-+]?\d+)?"
_RANGE = re.compile(rf"\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*")
_COMPARISON = re.compile(r"\s*(<=|>=)\s*(\S+)\s*")


@dataclass(frozen=True, slots=True)
class Limit:
    """One side of an expectation: `name` `relation` `bound`, the bound a number or another figure's name."""

    name: str
    relation: str
    bound: float | str


def parse_limits(
    expect: Mapping[str, float | str], parts: Mapping[str, Iterable[str]] | None = None
) -> list[Limit]:
    """The limits that a scenario's `[expect]` table sets.

    `parts` names what the run has, e.g. {"cpu": ["mcu"], "buses": ["spi1"], "faults": ["cable"]}.
    Raises UserError for a figure that does not exist or a limit that cannot be read.
    """
    empty = Scorer().result(0.0)
    known = set(flat_figures(empty.metrics, empty.gnss))
    for head, names in (parts or {}).items():
        known |= {f"{head}.{name}.{figure}" for name in names for figure in PER_PART[head]}
    limits: list[Limit] = []
    for name, text in expect.items():
        _must_be_known(name, known, f"expect.{name}")
        for relation, bound in _bounds(name, text):
            if isinstance(bound, str):
                _must_be_known(bound, known, f"expect.{name} = {text!r}")
            limits.append(Limit(name, relation, bound))
    return limits


def _bounds(name: str, text: float | str) -> list[tuple[str, float | str]]:
    if isinstance(text, int | float) and not isinstance(text, bool) and math.isfinite(text):
        more = name in MORE_IS_BETTER or name.endswith(".fired")
        return [(">=" if more else "<=", float(text))]
    if isinstance(text, str):
        if found := _RANGE.fullmatch(text):
            return [(">=", float(found[1])), ("<=", float(found[2]))]
        if found := _COMPARISON.fullmatch(text):
            number = re.fullmatch(_NUMBER, found[2])
            return [(found[1], float(found[2]) if number else found[2])]
    raise UserError(
        f"expect.{name} = {text!r}: not a limit; for example: {name} = 0.5, "
        f'{name} = ">= 0.9", {name} = "4.5 .. 18" or {name} = "<= gnss.position_horizontal_rms_m"'
    )


def _must_be_known(name: str, known: set[str], where: str) -> None:
    if name not in known:
        raise UserError(f"{where}: no figure named {name!r}; {did_you_mean(name, known)}")


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


def judge(limits: Sequence[Limit], figures: Mapping[str, float | None]) -> tuple[Expectation, ...]:
    """Hold the figures of a run against the limits, in their order."""
    return tuple(_judge_one(limit, figures) for limit in limits)


def _judge_one(limit: Limit, figures: Mapping[str, float | None]) -> Expectation:
    value = figures.get(limit.name)
    limit_name = limit.bound if isinstance(limit.bound, str) else None
    bound = figures.get(limit.bound) if isinstance(limit.bound, str) else limit.bound
    ok = False
    if value is not None and bound is not None:
        ok = value <= bound if limit.relation == "<=" else value >= bound
    return Expectation(limit.name, value, limit.relation, bound, ok, limit_name)
