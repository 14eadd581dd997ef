"""report.html: one page that tells a run, with everything in it that a browser needs, offline.

The bytes depend on the run alone: no date, no random identifiers, no wall-clock figures.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from host.record.result import RunResult
from host.record.run_data import RunData
from host.report.assets import SCRIPT, STYLE
from host.report.charts import Chart, charts
from host.report.numbers import number, percent
from host.report.summary import MET, NOT_MET, Section, sections, verdict
from host.report.timeline import timeline


def render(result: RunResult, manifest: Mapping[str, Any]) -> str:
    """The whole page. `result.data` holds the series; without it the page has tables only."""
    figures = charts(result.data) if result.data is not None else []
    timelines = [timeline(trace) for trace in result.data.traces] if result.data is not None else []
    tables = {section.title: _table(section) for section in sections(result)}
    title = f"{result.board} · {result.scenario} · {result.profile} · seed {result.seed}"
    body = [
        _header(result),
        *_take(tables, "Expectations", "Errors against the truth"),
        *map(_chart, figures),
        *_pair(_take(tables, "Consistency and coverage", "GNSS outages")),
        *_take(tables, "Recording: constants of the reference", "Recording: mounting"),
        *_pair(_take(tables, "Processors", "Buses")),
        *_take(tables, "Tasks"),
        *map(_chart, timelines),
        *tables.values(),
        _provenance(result, manifest),
    ]
    return _document(title, body, _scripts(result.data, figures, timelines))


def _take(tables: dict[str, str], *titles: str) -> list[str]:
    """Those of the tables that there are, taken out."""
    return [tables.pop(title) for title in titles if title in tables]


def _pair(blocks: Sequence[str]) -> list[str]:
    """Blocks side by side where the page is wide enough."""
    return ['<div class="pair">' + "".join(blocks) + "</div>"] if blocks else []


def _document(title: str, body: Sequence[str], scripts: str) -> str:
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(body)
        + f"\n</main>\n{scripts}</body>\n</html>\n"
    )


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
    return '<div class="cards">' + "".join(map(_card, cards)) + "</div>"


def _larger(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else max(one, other)


def _card(card: tuple[str, str]) -> str:
    return f'<div class="card"><b>{escape(card[0])}</b><span>{escape(card[1])}</span></div>'


def _table(section: Section) -> str:
    head = "".join(_cell("th", text, place, section) for place, text in enumerate(section.columns))
    rows = "\n".join(
        "<tr>" + "".join(_cell("td", text, place, section) for place, text in enumerate(row)) + "</tr>"
        for row in section.rows
    )
    note = f'<p class="note">{escape(section.note)}</p>' if section.note else ""
    return f"<section><h2>{escape(section.title)}</h2>{note}<table><tr>{head}</tr>\n{rows}</table></section>"


def _cell(tag: str, text: str, place: int, section: Section) -> str:
    kind = {MET: "ok", NOT_MET: "no"}.get(text, "word" if place < section.words else "")
    attribute = f' class="{kind}"' if kind else ""
    return f"<{tag}{attribute}>{escape(text)}</{tag}>"


def _chart(chart: Chart) -> str:
    return (
        f'<section><h2>{escape(chart.title)}</h2><p class="note">{escape(chart.explanation)}</p>'
        f'<div class="chart" id="{escape(chart.key)}"></div></section>'
    )


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
    if data is None or not (figures or timelines):
        return ""
    from plotly.offline import get_plotlyjs

    described = [
        {"key": chart.key, "traces": chart.traces, "layout": chart.layout, "time": chart.in_time}
        for chart in (*figures, *timelines)
    ]
    blocks = {"data": _columns(data, figures), "figures": described}
    return "".join(
        [f"<script>{get_plotlyjs()}</script>\n"]
        + [
            f'<script type="application/json" id="{key}">{_json(block)}</script>\n'
            for key, block in blocks.items()
        ]
        + [f"<script>{SCRIPT}</script>\n"]
    )


def _json(value: Any) -> str:
    return json.dumps(value, separators=(",", ":")).replace("</", "<\\/")


def _columns(data: RunData, figures: Sequence[Chart]) -> dict[str, str]:
    """The columns that the charts refer to, float32 little endian in base64."""
    names: set[str] = set()
    for chart in figures:
        for trace in chart.traces:
            for axis in ("x", "y"):
                names |= {trace[axis][key] for key in ("$", "plus") if key in trace[axis]}
    return {name: _encoded(_column(data, name)) for name in sorted(names)}


def _column(data: RunData, name: str) -> np.ndarray[Any, Any]:
    series, _, column = name.partition(".")
    if column.startswith("outage_"):
        t = data.solution.column("t_s")
        inside = np.zeros(len(t), dtype=bool)
        for start, duration in data.outages:
            inside |= (t >= start) & (t <= start + duration)
        return np.where(inside, data.solution.column(column.removeprefix("outage_")), np.nan)
    found: np.ndarray[Any, Any] = getattr(data, series).column(column)
    return found


def _encoded(values: np.ndarray[Any, Any]) -> str:
    return base64.b64encode(values.astype("<f4").tobytes()).decode()
