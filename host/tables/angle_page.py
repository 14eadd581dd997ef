"""The angle tables for people: ours beside the document's rows, and a page with the errors drawn."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import groupby
from typing import Any

from host.report.charts import FUSED, GNSS, OUTAGE_LINE, TRUTH, Chart, dots, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE
from host.report.summary import MET, NOT_MET, Section
from host.tables.angle_rows import CHIP, IDEAL, AngleRow
from host.tables.positions import HOLD_S, RATE_DPS, STEEP_DEG

TITLES = {CHIP: "the board, every word from the chip's registers", IDEAL: "exact rates at the kernel's door"}
COLOURS = (FUSED, GNSS, "#2e8b57")
DECIMALS = {CHIP: 3, IDEAL: 5}


def sections(rows: Sequence[AngleRow]) -> list[Section]:
    """One table for each axis and feed, arithmetics beside each other."""
    ordered = sorted(rows, key=lambda row: (row.feed, row.document.axis))
    groups = groupby(ordered, key=lambda row: (row.feed, row.document.axis))
    return [_section(feed, axis, list(group)) for (feed, axis), group in groups]


def summary(rows: Sequence[AngleRow]) -> Section:
    """The worst row of each table."""
    made = []
    for (feed, axis, arithmetic), found in groupby(sorted(rows, key=_of_table), key=_of_table):
        group = list(found)
        worst = max(group, key=lambda row: row.worst_deg)
        printed = max(row.document.worst_deg for row in group)
        verdict = MET if all(row.met for row in group) else NOT_MET
        ours = (_figure(worst.worst_deg, feed), f"{worst.document.angle_deg:g}", f"< {worst.goal_deg:g}")
        compensation = NONE if feed == IDEAL else "on" if worst.compensated else "off"
        words = (axis, feed, arithmetic, compensation)
        made.append((*words, str(len(group)), f"{printed:.3f}", *ours, verdict))
    columns = ("axis", "feed", "arithmetic", "compensation", "rows", "document's worst, °")
    title = "Angles of the rotary table: worst rows"
    return Section(title, (*columns, "ours, °", "at, °", "goal, °", "verdict"), tuple(made), words=4)


def _of_table(row: AngleRow) -> tuple[str, str, str]:
    return row.feed, row.document.axis, row.arithmetic


def _section(feed: str, axis: str, rows: list[AngleRow]) -> Section:
    arithmetics = list(dict.fromkeys(row.arithmetic for row in rows))
    columns = ["set, °", "document pitch", "roll", "yaw", "worst"]
    for arithmetic in arithmetics:
        columns += [f"{arithmetic} pitch", "roll", "yaw", "worst"]
    made = []
    by_angle = groupby(sorted(rows, key=lambda row: row.document.angle_deg), key=lambda row: row.document)
    for printed, found in by_angle:
        cells = [
            f"{printed.angle_deg:g}",
            *(f"{v:.3f}" for v in printed.measured_deg),
            f"{printed.worst_deg:.3f}",
        ]
        group = sorted(found, key=lambda row: arithmetics.index(row.arithmetic))
        for row in group:
            mark = " ∠" if row.is_steep else ""
            cells += [*(_figure(v, feed) for v in row.measured_deg), _figure(row.worst_deg, feed) + mark]
        made.append((*cells, MET if all(row.met for row in group) else NOT_MET))
    note = (
        f"{TITLES[feed].capitalize()}. From level at {RATE_DPS:g} °/s; the largest error within {HOLD_S:g} s"
        " of rest, each angle where it was farthest off."
    )
    if feed == CHIP:
        note += f" Drift compensation {'on' if rows[0].compensated else 'off'}."
    if axis == "pitch":
        note += f" ∠: from {STEEP_DEG:g}° on the total rotation is scored."
    return Section(f"Turned about {axis}: {feed}", (*columns, "verdict"), tuple(made), words=0, note=note)


def _figure(degrees: float, feed: str) -> str:
    return f"{degrees:.{DECIMALS[feed]}f}"


def to_dict(row: AngleRow) -> dict[str, Any]:
    """For JSON."""
    printed = row.document
    return {
        "axis": printed.axis,
        "set_deg": printed.angle_deg,
        "feed": row.feed,
        "arithmetic": row.arithmetic,
        "compensated": row.compensated,
        "measured_deg": dict(zip(("pitch", "roll", "yaw"), row.measured_deg, strict=True)),
        "error_deg": dict(zip(("pitch", "roll", "yaw"), row.error_deg, strict=True)),
        "rotation_deg": row.rotation_deg,
        "scored": "rotation" if row.is_steep else "angles",
        "worst_deg": row.worst_deg,
        "goal_deg": row.goal_deg,
        "met": row.met,
        "document": {
            "measured_deg": dict(zip(("pitch", "roll", "yaw"), printed.measured_deg, strict=True)),
            "error_deg": dict(zip(("pitch", "roll", "yaw"), printed.error_deg, strict=True)),
            "worst_deg": printed.worst_deg,
        },
    }


def page(title: str, rows: Sequence[AngleRow]) -> str:
    """One file that opens offline."""
    charts = [
        _chart(feed, axis, list(found))
        for (feed, axis), found in groupby(
            sorted(rows, key=lambda row: (row.feed, row.document.axis)),
            key=lambda row: (row.feed, row.document.axis),
        )
    ]
    tables = [table(one) for one in (summary(rows), *sections(rows))]
    body = [f"<header><h1>{escape(title)}</h1></header>", tables[0], *map(chart_block, charts), *tables[1:]]
    return document(title, body, chart_scripts({}, charts))


def _chart(feed: str, axis: str, rows: list[AngleRow]) -> Chart:
    arithmetics = list(dict.fromkeys(row.arithmetic for row in rows))
    traces = []
    for colour, arithmetic in zip(COLOURS, arithmetics, strict=False):
        mine = sorted(
            (row for row in rows if row.arithmetic == arithmetic), key=lambda row: row.document.angle_deg
        )
        angles = [row.document.angle_deg for row in mine]
        traces.append(
            line(angles, [row.worst_deg for row in mine], f"ours, {arithmetic}", colour, mode="lines+markers")
        )
    printed = sorted({row.document for row in rows}, key=lambda one: one.angle_deg)
    angles = [one.angle_deg for one in printed]
    traces.insert(0, dots(angles, [one.worst_deg for one in printed], "document", TRUTH, size=7))
    if len(angles) > 1:
        goal = rows[0].goal_deg
        traces.append(
            line([angles[0], angles[-1]], [goal, goal], f"goal {goal:g}°", OUTAGE_LINE, line={"dash": "dot"})
        )
    layout = {
        "xaxis": {"title": {"text": f"{axis} set, °"}},
        "yaxis": {"title": {"text": "largest error, °"}, "type": "log" if feed == IDEAL else "linear"},
        "height": 380,
    }
    return Chart(f"{feed}-{axis}", f"Turned about {axis}: {feed}", TITLES[feed] + ".", traces, layout)
