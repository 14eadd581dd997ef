"""report.html: one page that tells a run, with everything in it that a browser needs, offline.

The bytes depend on the run alone: no date, no random identifiers, no wall-clock figures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from host.record.result import RunResult
from host.record.run_data import RunData
from host.report.charts import Chart, charts
from host.report.filter_charts import FILTER_SERIES, filter_charts
from host.report.html import card, chart_block, chart_scripts, document, screen_blocks, table
from host.report.numbers import number, percent
from host.report.summary import sections, verdict
from host.report.timeline import timeline


def render(result: RunResult, manifest: Mapping[str, Any]) -> str:
    """The whole page. `result.data` holds the series; without it the page has tables only."""
    figures = [*charts(result.data), *filter_charts(result.data)] if result.data is not None else []
    timelines = [timeline(trace) for trace in result.data.traces] if result.data is not None else []
    tables = {section.title: table(section) for section in sections(result)}
    title = f"{result.board} · {result.scenario} · {result.profile} · seed {result.seed}"
    body = [
        _header(result),
        *_take(tables, "Expectations", "Errors against the truth"),
        *map(chart_block, figures),
        *_pair(_take(tables, "Consistency and coverage", "GNSS outages")),
        *_take(tables, "Recording: constants of the reference", "Recording: mounting"),
        *screen_blocks(result.data.screens if result.data is not None else []),
        *_pair(_take(tables, "Processors", "Buses")),
        *_take(tables, "Tasks"),
        *map(chart_block, timelines),
        *tables.values(),
        _provenance(result, manifest),
    ]
    return document(title, body, _scripts(result.data, figures, timelines))


def _take(tables: dict[str, str], *titles: str) -> list[str]:
    """Those of the tables that there are, taken out."""
    return [tables.pop(title) for title in titles if title in tables]


def _pair(blocks: Sequence[str]) -> list[str]:
    """Blocks side by side where the page is wide enough."""
    return ['<div class="pair">' + "".join(blocks) + "</div>"] if blocks else []


def _header(result: RunResult) -> str:
    kind = "none" if not result.expectations else "good" if result.ok else "bad"
    run = f"profile {result.profile} · seed {result.seed} · {result.duration_s:,.0f} s of virtual time"
    return (
        f"<header><h1>{escape(result.board)} — {escape(result.scenario)}</h1>"
        f'<span class="run">{escape(run)}</span></header>\n'
        f'<div class="verdict {kind}">{escape(_capital(verdict(result)))}</div>\n{_cards(result)}'
    )


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]


def _cards(result: RunResult) -> str:
    metrics = result.metrics
    alone = number(result.gnss.get("position_horizontal_rms_m"), "m")
    cards = [
        (number(metrics.get("position_horizontal_rms_m"), "m"), f"horizontal RMS, GNSS {alone}"),
        (number(metrics.get("velocity_rms_mps"), "m/s"), "velocity RMS"),
        (number(_larger(metrics.get("roll_rms_deg"), metrics.get("pitch_rms_deg")), "°"), "roll, pitch RMS"),
        (number(metrics.get("yaw_rms_deg"), "°"), "yaw RMS"),
        (number(metrics.get("nees_mean")), "mean NEES (honest: 9)"),
    ]
    if result.outages:
        drift = number(metrics.get("outage_horizontal_drift_median_m"), "m")
        count = len(result.outages)
        cards.append((drift, f"median drift of {count} outages" if count > 1 else "drift in the outage"))
    cards += [(percent(cpu.load), f"load of {cpu.name}") for cpu in result.cpu]
    return '<div class="cards">' + "".join(card(*one) for one in cards) + "</div>"


def _larger(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else max(one, other)


def _provenance(result: RunResult, manifest: Mapping[str, Any]) -> str:
    versions = " · ".join(f"{name} {number}" for name, number in manifest.get("versions", {}).items())
    texts = "".join(
        f"<details><summary>{escape(label)}</summary><pre>{escape(manifest[key])}</pre></details>"
        for label, key in (("Scenario file", "scenario_text"), ("Board file", "board_text"))
        if manifest.get(key)
    )
    overrides = manifest.get("overrides") or []
    changed = f"<p>Changed by --set: <code>{escape(', '.join(overrides))}</code></p>" if overrides else ""
    return (
        f"<section><h2>What ran</h2>{changed}{texts}</section>"
        f"<footer>{escape(versions)}<br>state hash {escape(result.state_hash)}</footer>"
    )


# -- data and script -------------------------------------------------------------------------------


def _scripts(data: RunData | None, figures: Sequence[Chart], timelines: Sequence[Chart]) -> str:
    return "" if data is None else chart_scripts(_columns(data, figures), (*figures, *timelines))


def _columns(data: RunData, figures: Sequence[Chart]) -> dict[str, np.ndarray[Any, Any]]:
    """The columns that the charts refer to."""
    names: set[str] = set()
    for chart in figures:
        for trace in chart.traces:
            for axis in ("x", "y"):
                names |= {trace[axis][key] for key in ("$", "plus") if key in trace[axis]}
    return {name: _column(data, name) for name in names}


def _column(data: RunData, name: str) -> np.ndarray[Any, Any]:
    series, _, column = name.partition(".")
    if column.startswith("outage_"):
        t = data.solution.column("t_s")
        inside = np.zeros(len(t), dtype=bool)
        for start, duration in data.outages:
            inside |= (t >= start) & (t <= start + duration)
        return np.where(inside, data.solution.column(column.removeprefix("outage_")), np.nan)
    if series.startswith(FILTER_SERIES):
        return data.filters[int(series.removeprefix(FILTER_SERIES))].column(column)
    found: np.ndarray[Any, Any] = getattr(data, series).column(column)
    return found
