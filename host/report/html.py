"""Blocks that every report page of ours is put together from: document, tables, charts, data and script.

A page holds everything that a browser needs, offline, and no date, random identifier or wall-clock figure.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from host.record.screens import Screen, png
from host.report.assets import SCRIPT, STYLE
from host.report.charts import Chart
from host.report.summary import MET, NOT_MET, Section


def document(title: str, body: Sequence[str], scripts: str) -> str:
    """The whole page."""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(body)
        + f"\n</main>\n{scripts}</body>\n</html>\n"
    )


def table(section: Section) -> str:
    """A table with its heading and note."""
    head = "".join(_cell("th", text, place, section) for place, text in enumerate(section.columns))
    rows = "\n".join(
        "<tr>" + "".join(_cell("td", text, place, section) for place, text in enumerate(row)) + "</tr>"
        for row in section.rows
    )
    note = f'<p class="note">{escape(section.note)}</p>' if section.note else ""
    return f"<section><h2>{escape(section.title)}</h2>{note}<table><tr>{head}</tr>\n{rows}</table></section>"


def _cell(tag: str, text: str, place: int, section: Section) -> str:
    kind = {MET: "ok", NOT_MET: "no"}.get(text, "word" if section.is_text(place) else "")
    attribute = f' class="{kind}"' if kind else ""
    return f"<{tag}{attribute}>{escape(text)}</{tag}>"


def chart_block(chart: Chart) -> str:
    """The place where the page's script draws a chart, with heading and explanation."""
    return (
        f'<section><h2>{escape(chart.title)}</h2><p class="note">{escape(chart.explanation)}</p>'
        f'<div class="chart" id="{escape(chart.key)}"></div></section>'
    )


def screen_blocks(screens: Sequence[Screen]) -> list[str]:
    """What was seen on the board's display, each picture with the instant from which it stood."""
    if not screens:
        return []
    pictures = "".join(
        f'<figure><img alt="display" width="256" src="data:image/png;base64,'
        f'{base64.b64encode(png(screen.picture)).decode()}"><figcaption>{screen.time_ns / 1e9:.1f} s'
        "</figcaption></figure>"
        for screen in screens
    )
    note = "What an operator saw, from the instant below each picture on."
    heading = f'<h2>Display</h2><p class="note">{note}</p>'
    return [f'<section>{heading}<div class="screens">{pictures}</div></section>']


def card(value: str, label: str) -> str:
    """One figure in large print."""
    return f'<div class="card"><b>{escape(value)}</b><span>{escape(label)}</span></div>'


def chart_scripts(columns: Mapping[str, np.ndarray[Any, Any]], charts: Sequence[Chart]) -> str:
    """plotly, the columns that the charts refer to, the charts, and what draws them; nothing without any."""
    if not charts:
        return ""
    from plotly.offline import get_plotlyjs

    described = [
        {"key": chart.key, "traces": chart.traces, "layout": chart.layout, "time": chart.in_time}
        for chart in charts
    ]
    encoded = {name: _encoded(values) for name, values in sorted(columns.items())}
    blocks: dict[str, Any] = {"data": encoded, "figures": described}
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


def _encoded(values: np.ndarray[Any, Any]) -> str:
    """float32 little endian in base64."""
    return base64.b64encode(values.astype("<f4").tobytes()).decode()
