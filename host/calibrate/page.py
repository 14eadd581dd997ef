"""A calibration for people: tables for terminal and page, curves of the compass, JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from host.calibrate.job import Outcome, PowerUp
from host.calibrate.judging import Coefficient, Figure, Judged
from host.report.charts import FUSED, GNSS, Chart, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE, number
from host.report.summary import MET, NOT_MET, Section

FORMAT = "navtwin-calibration-1"


def sections(outcome: Outcome) -> list[Section]:
    """The verdict first, then coefficients beside the truth."""
    made = [_verdict(outcome)]
    if outcome.power_ups:
        made.append(_power_ups(outcome.power_ups))
    made += [_coefficients(one) for one in outcome.procedures if one.coefficients]
    return made


def _verdict(outcome: Outcome) -> Section:
    rows: list[tuple[str, ...]] = []
    for one in outcome.procedures:
        if not one.account.done:
            rows.append((one.account.name, " ".join(one.account.lines), NONE, NONE, NONE, NOT_MET))
        rows += [(one.account.name, *_figure(figure)) for figure in one.figures]
    columns = ("procedure", "what", "nominal", "calibrated", "at most", "verdict")
    refused = sum(len(one.account.refusals) for one in outcome.procedures)
    note = (
        f"{outcome.duration_s:,.0f} s in settings mode, {refused} positions refused. Limits follow from the"
        " uncertainty that the board tells."
    )
    return Section("Calibration against the truth", columns, tuple(rows), 2, note)


def _figure(figure: Figure) -> tuple[str, str, str, str, str]:
    verdict = NONE if figure.limit is None else MET if figure.ok else NOT_MET
    limit = number(figure.limit, figure.unit)
    return figure.name, number(figure.before, figure.unit), number(figure.value, figure.unit), limit, verdict


def _power_ups(rows: Sequence[PowerUp]) -> Section:
    cells = [
        (
            f"{row.heading_deg:g}°",
            number(row.nominal_error_deg, "°"),
            number(row.calibrated_error_deg, "°"),
            MET if row.ok else NOT_MET,
        )
        for row in rows
    ]
    columns = ("magnetic heading", "nominal", "from the store", "verdict")
    note = "Error of the heading that the board aligns with, in acquisition mode after a new power-up."
    return Section("Used at the next power-up", columns, tuple(cells), 1, note)


def _coefficients(judged: Judged) -> Section:
    cells = [
        (
            one.name,
            _precise(one.true, one.unit),
            _precise(one.found, one.unit),
            number(one.sigma, one.unit),
            NONE if one.sigmas is None else f"{one.sigmas:+.1f}",
        )
        for one in judged.coefficients
    ]
    columns = ("coefficient", "true", "found", "1 σ", "error in σ")
    return Section(f"Coefficients: {judged.account.name}", columns, tuple(cells), 1)


def _precise(value: float | None, unit: str) -> str:
    return NONE if value is None else f"{value:.{3 if unit else 5}f} {unit}".rstrip()


def page(outcome: Outcome) -> str:
    """One file that opens offline."""
    title = f"{outcome.request.board} · calibration · seed {outcome.request.seed}"
    charts = [_heading_chart(one) for one in outcome.procedures if one.headings is not None]
    charts += [_sigma_chart(one) for one in outcome.procedures if one.coefficients]
    screens = [_screen(one) for one in outcome.procedures]
    body = [
        f"<header><h1>{escape(title)}</h1></header>",
        *map(table, sections(outcome)),
        *map(chart_block, charts),
        *screens,
    ]
    return document(title, body, chart_scripts({}, charts))


def _heading_chart(judged: Judged) -> Chart:
    assert judged.headings is not None
    heading, before, after = (np.degrees(column).tolist() for column in judged.headings)
    traces = [
        line(heading, before, "nominal", GNSS),
        line(heading, after, "calibrated", FUSED),
    ]
    layout = {
        "xaxis": {"title": {"text": "magnetic heading, °"}},
        "yaxis": {"title": {"text": "error, °"}},
        "height": 320,
    }
    name = judged.account.name
    return Chart(f"heading-{name}", f"Heading: {name}", "Without the compass's noise.", traces, layout)


def _sigma_chart(judged: Judged) -> Chart:
    told = [one for one in judged.coefficients if one.sigmas is not None]
    bars = {
        "type": "bar",
        "x": [one.name for one in told],
        "y": [one.sigmas for one in told],
        "marker": {"color": FUSED},
        "name": "error in σ",
    }
    layout = {"yaxis": {"title": {"text": "error in σ"}}, "height": 260}
    name = judged.account.name
    text = "Found less true, over the uncertainty that the board tells."
    return Chart(f"sigmas-{name}", f"Errors in σ: {name}", text, [bars], layout)


def _screen(judged: Judged) -> str:
    account = judged.account
    lines = "\n".join(account.lines)
    return f"<section><h2>Screen: {escape(account.name)}</h2><pre>{escape(lines)}</pre></section>"


def to_dict(outcome: Outcome) -> dict[str, Any]:
    """For JSON."""
    request = outcome.request
    return {
        "format": FORMAT,
        "board": request.board,
        "scenario": outcome.scenario,
        "profile": outcome.profile,
        "seed": request.seed,
        "duration_s": outcome.duration_s,
        "met": outcome.met,
        "procedures": [_procedure(one) for one in outcome.procedures],
        "power_ups": [
            {
                "heading_deg": row.heading_deg,
                "nominal_error_deg": _finite(row.nominal_error_deg),
                "calibrated_error_deg": _finite(row.calibrated_error_deg),
                "loaded": row.loaded,
                "ok": row.ok,
            }
            for row in outcome.power_ups
        ],
    }


def _procedure(one: Judged) -> dict[str, Any]:
    account = one.account
    return {
        "name": account.name,
        "done": account.done,
        "met": one.met,
        "took_s": account.took_s,
        "refusals": account.refusals,
        "screen": account.lines,
        "coefficients": [_coefficient(coefficient) for coefficient in one.coefficients],
        "figures": [_to_dict(figure) for figure in one.figures],
    }


def _coefficient(one: Coefficient) -> dict[str, Any]:
    told = {"name": one.name, "unit": one.unit, "found": one.found, "true": one.true, "sigma": one.sigma}
    return told | {"error_in_sigmas": one.sigmas}


def _to_dict(figure: Figure) -> dict[str, Any]:
    return {
        "name": figure.name,
        "unit": figure.unit,
        "before": figure.before,
        "value": _finite(figure.value),
        "limit": figure.limit,
        "ok": figure.ok,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
