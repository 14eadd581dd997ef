"""Allan curves for people: coefficients in the units of data sheets, and a page with the curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from typing import Any

from host.report.charts import FUSED, GNSS, TRUTH, Chart, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE, number
from host.report.summary import Section
from host.sim.errors.drawn import Triad, draw_specimen
from host.sim.errors.presets import load_preset
from host.simulate.allan import Curve

DEG = math.pi / 180.0
HOUR, ROOT_HOUR = 3600.0, 60.0
MGAL = 1e-5
COLOURS = (FUSED, GNSS, TRUTH)


def is_gyro(name: str) -> bool:
    """Whether a channel is one of angular rate."""
    return name.startswith("gyro")


def sections(curves: Sequence[Curve], preset: str | None) -> list[Section]:
    """A table of the gyros and one of the accelerometers."""
    walks = _set_walks(preset) if preset is not None else {}
    made = []
    for title, wanted, units in (
        ("Gyros", True, ("°/√h", "°/h", "°/h", "°/h/√h")),
        ("Accelerometers", False, ("m/s/√h", "mGal", "mGal", "mGal/√h")),
    ):
        rows = tuple(_row(one, walks) for one in curves if is_gyro(one.name) == wanted)
        columns = (
            *("axis", f"random walk N, {units[0]}"),
            *((f"set by {preset}",) if preset is not None else ()),
            *(f"instability B, {units[1]}", "at, s", f"Gauss–Markov σ, {units[2]}", "T, s"),
            *(f"rate random walk K, {units[3]}", "worst misfit, %"),
        )
        if rows:
            made.append(Section(title, columns, rows))
    return made


def _row(one: Curve, walks: dict[str, float]) -> tuple[str, ...]:
    c = one.coefficients
    size = DEG / HOUR if is_gyro(one.name) else MGAL
    walk = _walk(one.name, c.random_walk)
    return (
        one.name,
        number(walk),
        *((number(walks.get(one.name)),) if walks else ()),
        number(c.bias_instability / size),
        number(c.at_s),
        number(c.markov / size) if c.markov else NONE,
        number(c.markov_time_s) if c.markov else NONE,
        number(c.rate_random_walk * ROOT_HOUR / size),
        number(100.0 * c.worst_misfit),
    )


def _walk(name: str, value: float) -> float:
    """N in °/√h or m/s/√h."""
    return value * ROOT_HOUR / (DEG if is_gyro(name) else 1.0)


def _set_walks(preset: str) -> dict[str, float]:
    specimen = draw_specimen(load_preset(preset), 0, "imu")
    triads: tuple[tuple[str, Triad], ...] = (("gyro", specimen.gyro), ("accel", specimen.accelerometer))
    return {
        f"{kind}_{axis}": _walk(kind, density / math.sqrt(2.0))
        for kind, triad in triads
        for axis, density in zip("xyz", triad.noise_density.tolist(), strict=True)
    }


def to_dict(curves: Sequence[Curve]) -> list[dict[str, Any]]:
    """For JSON, in SI."""
    return [
        {
            "channel": one.name,
            **asdict(one.coefficients),
            "tau_s": one.tau_s.tolist(),
            "deviation": one.deviation.tolist(),
            "fit": one.fit.tolist(),
        }
        for one in curves
    ]


def page(title: str, curves: Sequence[Curve], tables: Sequence[Section]) -> str:
    """One file that opens offline."""
    drawn = []
    for key, heading, wanted, size, unit in (
        ("gyro", "Gyros", True, DEG / HOUR, "°/h"),
        ("accel", "Accelerometers", False, MGAL, "mGal"),
    ):
        traces = []
        of_kind = [one for one in curves if is_gyro(one.name) == wanted]
        for one, colour in zip(of_kind, COLOURS, strict=False):
            tau = one.tau_s.tolist()
            traces.append(line(tau, (one.deviation / size).tolist(), one.name, colour))
            fit = line(tau, (one.fit / size).tolist(), f"{one.name}, fit", colour)
            traces.append(fit | {"line": {"color": colour, "width": 1, "dash": "dot"}})
        if traces:
            axes = {
                "xaxis": {"type": "log", "title": {"text": "averaging time τ, s"}},
                "yaxis": {"type": "log", "title": {"text": f"Allan deviation, {unit}"}},
                "height": 420,
            }
            drawn.append(
                Chart(key, heading, "Solid: measured. Dotted: what the coefficients make.", traces, axes)
            )
    body = [f"<header><h1>{escape(title)}</h1></header>", *map(table, tables), *map(chart_block, drawn)]
    return document(title, body, chart_scripts({}, drawn))
