"""A comparison for people: tables for terminal and page, curves of how the differences grow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from host.compare.difference import QUANTITIES, UNITS, Difference
from host.compare.lockstep import GOAL_DEG, Comparison
from host.report.charts import FUSED, GNSS, Chart, line, on_row, stacked
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE, count, number
from host.report.summary import MET, NOT_MET, Section

GROWING = ("attitude", "yaw", "velocity", "position", "height")
SHOWN = ("attitude", "rate", "velocity", "position", "height")
COLOURS = (FUSED, GNSS, "#2e8b57")


def sections(comparison: Comparison, costs: Sequence[Section] = ()) -> list[Section]:
    """All tables; `costs` are those of the cycles."""
    made = [_whole(comparison), _first(comparison)]
    made += [_growth(difference) for difference in comparison.differences]
    return [*made, _saturations(comparison), *costs]


def _whole(comparison: Comparison) -> Section:
    rows = []
    for one in comparison.differences:
        for place, name in enumerate(QUANTITIES):
            rows.append(
                (
                    *(one.arithmetic, f"{name}, {UNITS[name]}", number(one.rms[name])),
                    *(number(float(one.largest[place])), number(float(one.largest_at_s[place]))),
                    *(number(one.at_end[name]), _verdict(comparison, one, name)),
                )
            )
    columns = ("arithmetic", "quantity", "RMS", "largest", "at, s", "at the end", "verdict")
    note = (
        f"Over {count(comparison.differences[0].count)} iterations from the same {count(comparison.bursts)}"
        f" bursts in {number(comparison.end_s - comparison.begin_s)} s: what is owed to the arithmetic alone."
        f" Drift compensation {'on' if comparison.compensated else 'off'}."
    )
    apart = sum(one.only_one for one in comparison.differences)
    if apart:
        note += f" {count(apart)} iterations were made by one of two only and are left out."
    return Section(f"Against {comparison.reference}", columns, tuple(rows), words=2, note=note)


def _verdict(comparison: Comparison, one: Difference, name: str) -> str:
    if name != "attitude" or one.arithmetic != "fixed" or comparison.met is None:
        return NONE
    return f"{MET if comparison.met else NOT_MET}"


def _first(comparison: Comparison) -> Section:
    rows = []
    for one in comparison.differences:
        found = sorted(one.first.items(), key=lambda item: item[1].t_s)
        rows += [
            (one.arithmetic, f"{name}, {UNITS[name]}", f"{first.t_s:.6f}", number(first.amount))
            for name, first in found
        ]
        rows += [
            (one.arithmetic, f"{name}, {UNITS[name]}", "never", NONE)
            for name in QUANTITIES
            if name not in one.first
        ]
    columns = ("arithmetic", "quantity", "at, s", "difference")
    note = "When the records first differ by a count: 1e-9 rad, 1e-9 °, 1 µm, 1 µm/s."
    return Section("First divergence", columns, tuple(rows), words=2, note=note)


def _growth(one: Difference) -> Section:
    places = [QUANTITIES.index(name) for name in SHOWN]
    rows = []
    for state in one.growth:
        figures = [number(float(state.now[place])) for place in places]
        rows.append(
            (f"{state.since_s:,.0f}", *figures, number(float(state.rms[0])), number(float(state.largest[0])))
        )
    columns = ("since the first iteration, s", *(f"{name}, {UNITS[name]}" for name in SHOWN))
    title = f"Growth of the error: {one.arithmetic} against {one.reference}"
    return Section(title, (*columns, "attitude RMS so far", "largest so far"), tuple(rows), words=0)


def _saturations(comparison: Comparison) -> Section:
    rows = tuple(
        (name, count(comparison.iterations[name]), count(sum(kinds.values())), _kinds(kinds))
        for name, kinds in comparison.saturations.items()
    )
    return Section("Saturations", ("arithmetic", "iterations", "saturations", "of which"), rows, words=1)


def _kinds(kinds: Mapping[str, int]) -> str:
    return ", ".join(f"{name} {number:,}" for name, number in kinds.items() if number) or NONE


def to_dict(comparison: Comparison) -> dict[str, Any]:
    """For JSON."""
    return {
        "reference": comparison.reference,
        "bursts": comparison.bursts,
        "begin_s": comparison.begin_s,
        "end_s": comparison.end_s,
        "drift_compensation": comparison.compensated,
        "goal_deg": GOAL_DEG,
        "met": comparison.met,
        "iterations": comparison.iterations,
        "saturations": comparison.saturations,
        "arithmetics": {one.arithmetic: _difference(one) for one in comparison.differences},
    }


def _difference(one: Difference) -> dict[str, Any]:
    return {
        "iterations": one.count,
        "made_by_one_only": one.only_one,
        "rms": one.rms,
        "largest": dict(zip(QUANTITIES, one.largest.tolist(), strict=True)),
        "largest_at_s": dict(zip(QUANTITIES, one.largest_at_s.tolist(), strict=True)),
        "at_end": one.at_end,
        "first": {name: {"t_s": first.t_s, "amount": first.amount} for name, first in one.first.items()},
        "growth": [
            {
                "since_s": state.since_s,
                "difference": dict(zip(QUANTITIES, state.now.tolist(), strict=True)),
                "rms": dict(zip(QUANTITIES, state.rms.tolist(), strict=True)),
                "largest": dict(zip(QUANTITIES, state.largest.tolist(), strict=True)),
            }
            for state in one.growth
        ],
        "units": UNITS,
    }


def page(title: str, comparison: Comparison, tables: Sequence[Section]) -> str:
    """One file that opens offline, with `sections`."""
    chart = _chart(comparison)
    whole, *others = map(table, tables)
    body = [f"<header><h1>{escape(title)}</h1></header>", whole, chart_block(chart), *others]
    return document(title, body, chart_scripts({}, [chart]))


def _chart(comparison: Comparison) -> Chart:
    traces = []
    for colour, one in zip(COLOURS, comparison.differences, strict=False):
        times = one.series.column("t_s").tolist()
        for place, name in enumerate(GROWING):
            values = one.series.column(name)
            shown = np.where(values > 0.0, values, np.nan)
            traces.append(on_row(line(times, _without_nan(shown), one.arithmetic, colour), place))
    labels = [f"{name}, {UNITS[name]}" for name in GROWING]
    layout = stacked(labels, [comparison.begin_s, comparison.end_s])
    for place in range(len(GROWING)):
        layout[f"yaxis{place + 1}" if place else "yaxis"]["type"] = "log"
    text = f"Differences to {comparison.reference} on one stream of words; equal records leave a gap."
    return Chart("growth", "How the errors grow", text, traces, layout, in_time=True)


def _without_nan(values: np.ndarray[Any, Any]) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in values]
