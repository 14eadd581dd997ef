"""The filters of gfsins for people: beside the document, failures, curves like its figures 5.1 to 5.3."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from host.report.charts import FUSED, GNSS, OUTAGE_LINE, Chart, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE, counted, number
from host.report.summary import MET, NOT_MET, Section
from host.tables.federated_rows import FilterRow

TITLE = "Filters side by side on the conditions of chapter 5"
COLOURS = (FUSED, GNSS, OUTAGE_LINE)


def filter_section(rows: Sequence[FilterRow], duration_s: int, seeds: int) -> Section:
    """One row a filter."""
    cells = [
        (
            row.name,
            row.document or NONE,
            row.goal,
            f"{math.degrees(row.tilt):.3f}",
            f"{math.degrees(row.yaw):.3f}",
            number(row.velocity),
            number(row.position),
            number(row.end_position),
            {True: MET, False: NOT_MET, None: NONE}[row.met],
        )
        for row in rows
    ]
    columns = (
        "filter", "document", "goal", "tilt, °", "heading, °", "velocity, m/s", "position, m",
        "position at the end, m", "verdict",
    )  # fmt: skip
    note = (
        f"Feed: equivalent. RMS from 60 s to {duration_s} s, axes together, {counted(seeds, 'seed')}: 80 km/h"
        " straight on, 0.1 °/s and 5 mg of bias, compass 10 Hz, GPS 1 Hz."
    )
    return Section(TITLE, columns, tuple(cells), 3, note)


def filter_dict(row: FilterRow) -> dict[str, Any]:
    """For JSON."""
    return {
        "filter": row.name,
        "document": row.document,
        "goal": row.goal,
        "tilt_rms_deg": math.degrees(row.tilt),
        "heading_rms_deg": math.degrees(row.yaw),
        "velocity_rms_mps": row.velocity,
        "position_rms_m": row.position,
        "position_end_m": row.end_position,
        "detail": row.detail,
        "met": row.met,
    }


def page(sections: Sequence[Section], rows: Sequence[FilterRow]) -> str:
    """One file that opens offline."""
    charts = [chart for row in rows for chart in _charts(row)]
    body = [f"<header><h1>{escape(TITLE)}</h1></header>", *map(table, sections), *map(chart_block, charts)]
    return document(TITLE, body, chart_scripts({}, charts))


def _charts(row: FilterRow) -> list[Chart]:
    errors = row.shown
    kinds = (
        ("attitude", np.degrees(errors.attitude), "error, °", ("roll", "pitch", "heading")),
        ("velocity", errors.velocity, "error, m/s", ("north", "east", "down")),
        ("position", errors.position, "error, m", ("north", "east", "down")),
    )
    times = list(range(1, len(errors.position) + 1))
    charts = []
    for kind, values, unit, names in kinds:
        traces = [
            line(times, values[:, place].tolist(), name, colour)
            for place, (name, colour) in enumerate(zip(names, COLOURS, strict=True))
        ]
        layout = {
            "xaxis": {"title": {"text": "time, s"}},
            "yaxis": {"title": {"text": unit}},
            "height": 300,
        }
        key = f"{row.name}-{kind}".replace(" ", "-").replace(",", "")
        charts.append(Chart(key, f"{row.name}: {kind}", "First seed.", traces, layout))
    return charts
