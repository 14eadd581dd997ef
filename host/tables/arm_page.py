"""The table of arm lengths for people, and its curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from typing import Any

from host.report.charts import FUSED, GNSS, OUTAGE_LINE, Chart, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import number
from host.report.summary import Section
from host.tables.arm_rows import ArmRow

TITLE = "Arms of gfsins with real accelerometers"
COLUMNS = (
    "arm, m", "rate, one axis, °/s", "rate, all axes, °/s", "tilt, °", "heading, °",
    "heading, 10 s without compass, °", "position, m", "60 s without GPS, m", "velocity then, m/s",
)  # fmt: skip


def section(rows: Sequence[ArmRow], seed: int) -> Section:
    """One row a length."""
    cells = [
        (
            f"{row.arm_m:g}",
            number(math.degrees(row.rate_one_axis)),
            number(math.degrees(row.rate_all_axes)),
            *(number(value) for value in list(asdict(row).values())[3:]),
        )
        for row in rows
    ]
    note = (
        "Rate: RMS over a minute by itself. The rest: the board on scenario losses, profile adxl345,"
        f" seed {seed}; RMS with compass and GPS, the largest heading error in 10 s without compass, position"
        " after 60 s without GPS."
    )
    return Section(TITLE, COLUMNS, tuple(cells), 0, note)


def to_dict(row: ArmRow) -> dict[str, Any]:
    """For JSON."""
    told = asdict(row)
    for name in ("rate_one_axis", "rate_all_axes"):
        told[f"{name}_dps"] = math.degrees(told.pop(name))
    return told


def page(shown: Section, rows: Sequence[ArmRow]) -> str:
    """One file that opens offline."""
    charts = [_chart(rows)]
    body = [f"<header><h1>{escape(TITLE)}</h1></header>", table(shown), *map(chart_block, charts)]
    return document(TITLE, body, chart_scripts({}, charts))


def _chart(rows: Sequence[ArmRow]) -> Chart:
    arms = [row.arm_m for row in rows]
    traces = [
        line(arms, [math.degrees(row.rate_one_axis) for row in rows], "rate by itself, °/s", FUSED),
        line(
            arms, [row.heading_without_compass_deg for row in rows], "heading, 10 s without compass, °", GNSS
        ),
        line(arms, [row.heading_deg for row in rows], "heading with compass, °", OUTAGE_LINE),
    ]
    layout = {
        "xaxis": {"title": {"text": "arm, m"}, "type": "log"},
        "yaxis": {"title": {"text": "error"}, "type": "log"},
        "height": 380,
    }
    text = "Noise of the rate falls with the length of the arms; what the compass holds hardly changes."
    return Chart("arms", "Errors and arm length", text, traces, layout)
