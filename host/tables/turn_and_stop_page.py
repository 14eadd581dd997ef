"""The drift test for people."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from host.report.charts import FUSED, GNSS, OUTAGE_LINE, Chart, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE, counted, number
from host.report.summary import MET, NOT_MET, Section
from host.tables.turn_and_stop import StopDrift

ANGLES = ("pitch", "roll", "yaw")
COLOURS = (FUSED, GNSS, OUTAGE_LINE)
TITLE = "Turn and stop"


def section(drifts: Sequence[StopDrift]) -> Section:
    """The document's row, then ours."""
    known = drifts[0].document
    rows = [("document", NONE, NONE, *(f"{value:.3f}" for value in known.drift_deg), NONE, NONE, NONE, NONE)]
    for one in drifts:
        verdict = {True: MET, False: NOT_MET, None: NONE}[one.met]
        figures = [f"{value:.3f}" for value in (*one.rms_deg, *one.worst_deg)]
        rows.append(("ours", one.arithmetic, _compensation(one), *figures, verdict))
    columns = ("", "arithmetic", "compensation", "pitch, °", "roll, °", "yaw, °")
    note = (
        f"Largest error within {known.after_s:g} s behind a fast turn to yaw {known.yaw_deg:+g}°: RMS and"
        f" worst of {counted(len(drifts[0].seeds), 'seed')}. With compensation each must stay below that."
    )
    return Section(TITLE, (*columns, "worst pitch, °", "roll, °", "yaw, °", "verdict"), tuple(rows), 3, note)


def _compensation(drift: StopDrift) -> str:
    return "on" if drift.compensated else "off"


def to_dict(drift: StopDrift) -> dict[str, Any]:
    """For JSON."""
    return {
        "arithmetic": drift.arithmetic,
        "compensation": drift.compensated,
        "seeds": list(drift.seeds),
        "largest_deg": [dict(zip(ANGLES, row, strict=True)) for row in drift.largest_deg.tolist()],
        "rms_deg": dict(zip(ANGLES, drift.rms_deg, strict=True)),
        "worst_deg": dict(zip(ANGLES, drift.worst_deg, strict=True)),
        "document_deg": dict(zip(ANGLES, drift.document.drift_deg, strict=True)),
        "met": drift.met,
    }


def page(drifts: Sequence[StopDrift]) -> str:
    """One file that opens offline."""
    charts = [_chart(one) for one in drifts]
    body = [f"<header><h1>{escape(TITLE)}</h1></header>", table(section(drifts)), *map(chart_block, charts)]
    return document(TITLE, body, chart_scripts({}, charts))


def _chart(drift: StopDrift) -> Chart:
    times = drift.times_s.tolist()
    traces = [
        line(times, drift.error_deg[:, place].tolist(), name, colour)
        for place, (name, colour) in enumerate(zip(ANGLES, COLOURS, strict=True))
    ]
    largest = max(drift.document.drift_deg)
    layout = {
        "xaxis": {"title": {"text": "since the stop, s"}},
        "yaxis": {"title": {"text": "error, °"}, "range": [-largest, largest]},
        "height": 360,
    }
    title = f"{drift.arithmetic}, compensation {_compensation(drift)}"
    text = f"Errors of seed {drift.seeds[0]}; the axis goes to the document's {number(largest)}°."
    return Chart(f"stop-{drift.arithmetic}-{_compensation(drift)}", title, text, traces, layout)
