"""The estimated cycles for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from host.compare.cost import BURSTS, CLOCK_HZ, DOCUMENT_S, Cost
from host.cycles.prices import KINDS
from host.report.numbers import NONE, count, number
from host.report.summary import Section

LABELS = {
    "take_burst": "take_burst: 14 words looked at, converted, into the ring",
    "iteration": "iteration: attitude, velocity, position over 8 ms",
    "solution": "solution: the record of angles, rates, velocity, position",
}


def section(costs: Sequence[Cost]) -> Section:
    """One row a kernel, then the solution as a whole beside the document's."""
    made: list[tuple[str, ...]] = []
    for name, label in LABELS.items():
        means = [one.calls[name].per_call if _ran(one, name) else None for one in costs]
        if any(mean is not None for mean in means):
            made.append((label, str(BURSTS.get(name, 1)), *(cell for mean in means for cell in _cells(mean))))
    made.append(("one solution", "", *(cell for one in costs for cell in _cells(one.solution))))
    made.append(("document's solution", "", *_cells(DOCUMENT_S * CLOCK_HZ) * len(costs)))
    columns = ["kernel", "calls"]
    for one in costs:
        columns += [f"{_name(one)}, cycles", "µs"]
    note = (
        f"Estimated for a C28x at {CLOCK_HZ / 1e6:g} MHz from the kernels' intermediate code; the mean of all"
        f" calls (docs/uav_ahrs.md tells how). Update: {costs[0].method}."
    )
    return Section("Cycles", tuple(columns), tuple(made), note=note)


def _name(cost: Cost) -> str:
    return f"{cost.arithmetic}, compensated" if cost.compensated else cost.arithmetic


def _ran(cost: Cost, name: str) -> bool:
    return name in cost.calls and cost.calls[name].calls > 0


def _cells(cycles: float | None) -> tuple[str, str]:
    if cycles is None:
        return NONE, NONE
    return count(round(cycles, -1)), number(1e6 * cycles / CLOCK_HZ)


def kinds_section(costs: Sequence[Cost]) -> Section:
    """What the cycles of one solution go into."""
    rows = []
    for kind in KINDS:
        shares = [_of_kind(one, kind) for one in costs]
        if any(shares):
            rows.append((kind, *(count(share) for share in shares)))
    return Section("What they go into", ("kind", *(f"{_name(one)}, cycles" for one in costs)), tuple(rows))


def _of_kind(cost: Cost, kind: str) -> float:
    return sum(
        one.by_kind[kind] / one.calls * BURSTS.get(name, 1) for name, one in cost.calls.items() if one.calls
    )


def methods_section(costs: Sequence[Cost], names: Mapping[str, str]) -> Section:
    """Cycles of an iteration with each update method; `names` tells them to people."""
    arithmetics = list(dict.fromkeys(one.arithmetic for one in costs))
    rows = []
    for method in dict.fromkeys(one.method for one in costs):
        found = {one.arithmetic: one.calls["iteration"].per_call for one in costs if one.method == method}
        rows.append((names[method], *(_cells(found[one])[0] for one in arithmetics)))
    columns = ("update", *(f"{one}, cycles" for one in arithmetics))
    return Section("An iteration with each update", columns, tuple(rows))


def to_dict(cost: Cost) -> dict[str, Any]:
    """For JSON."""
    return {
        "arithmetic": cost.arithmetic,
        "update": cost.method,
        "compensated": cost.compensated,
        "clock_hz": CLOCK_HZ,
        "solution_cycles": cost.solution,
        "solution_s": cost.solution / CLOCK_HZ,
        "document_solution_s": DOCUMENT_S,
        "kernels": {
            name: {
                "calls": one.calls,
                "cycles_per_call": one.per_call,
                "by_kind": {kind: cycles / one.calls for kind, cycles in one.by_kind.items() if cycles},
            }
            for name, one in cost.calls.items()
            if one.calls
        },
    }
