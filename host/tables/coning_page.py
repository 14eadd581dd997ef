"""The coning table for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from host.report.charts import FUSED, GNSS, OUTAGE_LINE, TRUTH, Chart, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE
from host.report.summary import Section
from host.tables.coning import Coning, ConingDrift

NAMES = {
    "rk4": "Runge-Kutta 4 (2-37)",
    "rotation_vector_1": "rotation vector, order 1 (2-33)",
    "rotation_vector_2": "rotation vector, order 2 (2-34)",
    "rotation_vector_3": "rotation vector, order 3 (2-35)",
    "rotation_vector_4": "rotation vector, order 4 (2-36)",
    "two_sample": "rotation vector, two samples",
    "euler_angles": "Euler angles (2-9)",
    "direction_cosines": "direction cosines (2-10)",
}
SUMMED = ("rotation_vector_1", "rotation_vector_2", "rotation_vector_3", "rotation_vector_4")
COLOURS = (FUSED, GNSS, OUTAGE_LINE, TRUTH, "#2e8b57", "#8e44ad", "#b8860b", "#008b8b")


def section(coning: Coning, drifts: Sequence[ConingDrift]) -> Section:
    """One row an update, one column an arithmetic."""
    arithmetics = list(dict.fromkeys(one.arithmetic for one in drifts))
    rows = []
    for method in dict.fromkeys(one.method for one in drifts):
        mine = {one.arithmetic: one for one in drifts if one.method == method}
        cells = [f"{math.degrees(mine[name].drift):.5f}" if name in mine else NONE for name in arithmetics]
        known = f"{math.degrees(coning.drift_of_summed_angles):.5f}" if method in SUMMED else NONE
        rows.append((NAMES[method], *cells, known))
    columns = ("update", *(f"{name}, °" for name in arithmetics), "summed angles in closed form, °")
    return Section(_title(coning), columns, tuple(rows), note=_note(coning))


def _title(coning: Coning) -> str:
    half = math.degrees(coning.half_angle)
    return (
        f"Drift under coning, {coning.frequency_hz:g} Hz, {half:g}° half angle, after {coning.duration_s:g} s"
    )


def _note(coning: Coning) -> str:
    return (
        f"Total rotation against the closed form. Exact rates at the kernel's door every"
        f" {500 * coning.period:g} ms, an iteration every {1000 * coning.period:g} ms."
    )


def to_dict(coning: Coning, drift: ConingDrift) -> dict[str, Any]:
    """For JSON."""
    closed = math.degrees(coning.drift_of_summed_angles) if drift.method in SUMMED else None
    return {
        "update": drift.method,
        "arithmetic": drift.arithmetic,
        "drift_deg": math.degrees(drift.drift),
        "closed_form_deg": closed,
        "saturations": drift.saturations,
        "t_s": drift.times_s.tolist(),
        "error_deg": np.degrees(drift.error).tolist(),
    }


def page(coning: Coning, drifts: Sequence[ConingDrift]) -> str:
    """One file that opens offline."""
    charts = []
    for arithmetic in dict.fromkeys(one.arithmetic for one in drifts):
        mine = [one for one in drifts if one.arithmetic == arithmetic]
        traces = [
            line(one.times_s.tolist(), np.degrees(one.error).tolist(), NAMES[one.method], colour)
            for colour, one in zip(COLOURS, mine, strict=False)
        ]
        layout = {
            "xaxis": {"title": {"text": "time, s"}},
            "yaxis": {"title": {"text": "total rotation against the closed form, °"}, "type": "log"},
            "height": 460,
        }
        charts.append(Chart(f"coning-{arithmetic}", f"In {arithmetic}", _note(coning), traces, layout))
    body = [f"<header><h1>{escape(_title(coning))}</h1></header>", table(section(coning, drifts))]
    return document(_title(coning), [*body, *map(chart_block, charts)], chart_scripts({}, charts))
