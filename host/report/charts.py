"""The report's charts as plotly figures: plain dictionaries, with references to columns for data.

A reference {"$": "solution.t_s"} stands for a column of the page's data block, so that a column that several
traces share is stored once; "times" multiplies it. The page's script (`host.report.assets`) puts them in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from host.record.run_data import NAVIGATING, RunData

FUSED, TRUTH, GNSS, BAND, OUTAGE = (
    "#1c6dd0",
    "#22262b",
    "#e8710a",
    "rgba(28,109,208,0.15)",
    "rgba(200,60,50,0.10)",
)
OUTAGE_LINE = "#c0392b"
GRID = "#e6e9ee"

Trace = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Chart:
    """One chart of the report: heading, a sentence on what is shown, plotly traces and layout."""

    key: str
    title: str
    explanation: str
    traces: list[Trace]
    layout: dict[str, Any]
    in_time: bool = False
    """The x axis is the run's time: such charts are zoomed together."""


def charts(data: RunData) -> list[Chart]:
    """All charts that there are data for."""
    made: list[Chart] = []
    if len(data.solution):
        made.append(_track(data))
        made += [_errors(data, *one) for one in ERRORS]
    if len(data.innovations):
        made.append(_innovations(data))
    if len(data.biases):
        made.append(_biases(data))
    if len(data.sensor):
        made.append(_sensor(data))
    return made


def column(name: str, times: float = 1) -> dict[str, Any]:
    """Reference to a column of the data block."""
    return {"$": name} if times == 1 else {"$": name, "times": times}


def line(x: Any, y: Any, name: str, colour: str, **more: Any) -> Trace:
    """A trace of lines."""
    style = {"color": colour, "width": more.pop("width", 1.4)} | more.pop("line", {})
    return {"type": "scatter", "mode": "lines", "x": x, "y": y, "name": name, "line": style} | more


def dots(x: Any, y: Any, name: str, colour: str, **more: Any) -> Trace:
    """A trace of points."""
    marker = {"color": colour, "size": more.pop("size", 4), "opacity": 0.75}
    return {"type": "scatter", "mode": "markers", "x": x, "y": y, "name": name, "marker": marker} | more


# -- track -----------------------------------------------------------------------------------------


def _track(data: RunData) -> Chart:
    true_place = (column("solution.true_east_m"), column("solution.true_north_m"))
    place = (column("solution.east_m"), column("solution.north_m"))
    receiver = (column("gnss.east_m"), column("gnss.north_m"))
    traces = [
        dots(*receiver, "GNSS alone", GNSS),
        line(*true_place, "truth", TRUTH, width=1.2),
        line(*place, "fused", FUSED, width=1.8),
    ]
    if data.outages:
        inside = (column("solution.outage_east_m"), column("solution.outage_north_m"))
        traces.append(line(*inside, "fused during an outage", OUTAGE_LINE, width=3))
    layout = {
        "height": 620,
        "xaxis": axis("east, m", zeroline=False),
        "yaxis": axis("north, m", zeroline=False, scaleanchor="x", scaleratio=1),
    }
    text = "Seen from above, in the plane at the first position. Scroll to zoom, drag to pan."
    return Chart("track", "Track", text, traces, layout | {"dragmode": "pan"})


# -- stacked time series ---------------------------------------------------------------------------

ERRORS: tuple[tuple[str, str, tuple[tuple[str, str, str], ...], str, bool], ...] = (
    (
        "position",
        "Position error",
        (
            ("north, m", "error_north_m", "sigma_north_m"),
            ("east, m", "error_east_m", "sigma_east_m"),
            ("down, m", "error_down_m", "sigma_down_m"),
        ),
        "Solution minus truth, with the filter's own 3 σ around zero.",
        True,
    ),
    (
        "velocity",
        "Velocity error",
        (
            ("north, m/s", "error_v_north_mps", "sigma_v_north_mps"),
            ("east, m/s", "error_v_east_mps", "sigma_v_east_mps"),
            ("down, m/s", "error_v_down_mps", "sigma_v_down_mps"),
        ),
        "Solution minus truth, with the filter's own 3 σ around zero.",
        True,
    ),
    (
        "attitude",
        "Attitude error",
        (
            ("roll, °", "error_roll_deg", "sigma_psi_n_deg"),
            ("pitch, °", "error_pitch_deg", "sigma_psi_e_deg"),
            ("yaw, °", "error_yaw_deg", "sigma_psi_d_deg"),
        ),
        "Solution minus truth. The 3 σ of the tilt about north and east stand behind roll and pitch.",
        False,
    ),
)


def _errors(
    data: RunData, key: str, title: str, rows: tuple[tuple[str, str, str], ...], text: str, with_gnss: bool
) -> Chart:
    traces: list[Trace] = []
    time = column("solution.t_s")
    for place, (_, error, sigma) in enumerate(rows):
        traces += _band(time, f"solution.{sigma}", place)
        if with_gnss:
            receiver = dots(column("gnss.t_s"), column(f"gnss.{error}"), "GNSS alone", GNSS, size=3)
            traces.append(on_row(receiver, place))
        traces.append(on_row(line(time, column(f"solution.{error}"), "fused", FUSED), place))
    labels = [label for label, _, _ in rows]
    ranges = [_focus(data, f"{error}", sigma) for _, error, sigma in rows]
    return Chart(key, title, text, traces, _stacked(labels, data, ranges), in_time=True)


def _innovations(data: RunData) -> Chart:
    names = ("north_m", "east_m", "down_m", "v_north_mps", "v_east_mps", "v_down_mps")
    labels = ("north, m", "east, m", "down, m", "v north, m/s", "v east, m/s", "v down, m/s")
    time = column("innovations.t_s")
    traces: list[Trace] = []
    for place, name in enumerate(names):
        traces += _band(time, f"innovations.sigma_{name}", place)
        points = dots(time, column(f"innovations.{name}"), "innovation", FUSED, size=3)
        traces.append(on_row(points, place))
    text = "What each GNSS update told the filter beyond its prediction, with 3 σ of the prediction."
    return Chart("innovations", "Innovations", text, traces, _stacked(labels, data), in_time=True)


def _biases(data: RunData) -> Chart:
    names = ("gyro_x_dps", "gyro_y_dps", "gyro_z_dps", "accel_x_mps2", "accel_y_mps2", "accel_z_mps2")
    labels = ("gyro x, °/s", "gyro y, °/s", "gyro z, °/s", "acc x, m/s²", "acc y, m/s²", "acc z, m/s²")
    time = column("biases.t_s")
    traces: list[Trace] = []
    for place, name in enumerate(names):
        traces += _band(time, f"biases.sigma_{name}", place, around=f"biases.{name}")
        true = line(time, column(f"biases.true_{name}"), "truth", TRUTH, line={"dash": "dot"})
        traces.append(on_row(true, place))
        traces.append(on_row(line(time, column(f"biases.{name}"), "estimate", FUSED), place))
    text = "Sensor biases as the filter estimates them, with 3 σ, and as the simulated sensor has them."
    return Chart("biases", "Sensor biases", text, traces, _stacked(labels, data), in_time=True)


SENSOR_ROWS = (
    ("supply, V", (("supply", "supply_mv", 1e-3),)),
    ("temperature, °C", (("temperature", "temperature_centi_c", 0.01),)),
    ("pressure, hPa", (("pressure", "pressure_pa", 0.01),)),
    ("field, µT", (("field", "field_nt", 1e-3),)),
    ("age, ms", (("youngest sample", "age_least_us", 1e-3), ("oldest sample", "age_most_us", 1e-3))),
    ("bridged", (("bridged", "bridged", 1),)),
)
"""Label of the axis; name, column and factor of each line."""


def _sensor(data: RunData) -> Chart:
    time = column("sensor.t_s")
    colours = (FUSED, GNSS)
    traces = [
        on_row(line(time, column(f"sensor.{name}", times), told, colour), place)
        for place, (_, lines) in enumerate(SENSOR_ROWS)
        for colour, (told, name, times) in zip(colours, lines, strict=False)
    ]
    text = (
        "What the inertial sensor tells of itself and its surroundings, how old its samples were in the"
        " solutions, and how many bursts had to be bridged."
    )
    labels = [label for label, _ in SENSOR_ROWS]
    layout = _stacked(labels, data) | {"showlegend": False}
    return Chart("sensor", "Sensor's health", text, traces, layout, in_time=True)


def _band(time: Any, sigma: str, place: int, around: str | None = None) -> list[Trace]:
    """3 σ as a filled band around zero, or around another column."""
    edges = []
    for side in (-3, 3):
        y: dict[str, Any] = column(sigma, side)
        if around is not None:
            y["plus"] = around
        edges.append(line(time, y, "3 σ", BAND, width=0, hoverinfo="skip"))
    edges[0]["showlegend"] = False
    edges[1] |= {"fill": "tonexty", "fillcolor": BAND}
    return [on_row(edge, place) for edge in edges]


def on_row(trace: Trace, place: int) -> Trace:
    """Put a trace on the `place`-th of the stacked axes; the first one stands in the legend for all."""
    group = {"legendgroup": trace["name"], "yaxis": f"y{place + 1}" if place else "y"}
    hidden = {"showlegend": False} if place or trace.get("showlegend") is False else {}
    return trace | group | hidden


def _focus(data: RunData, error: str, sigma: str) -> list[float] | None:
    """A y range for the time after alignment: all errors; 3 σ and GNSS up to three times as much."""
    kept = data.solution.column("mode") >= NAVIGATING
    settled = np.flatnonzero(kept)[np.count_nonzero(kept) // 20 :]
    if len(settled) == 0:
        return None
    error_bound = np.nanmax(np.abs(data.solution.column(error)[settled]))
    beside = 3 * data.solution.column(sigma)[settled]
    if error in data.gnss.columns and len(data.gnss):
        beside = np.append(beside, np.abs(data.gnss.column(error)))
    known = beside[np.isfinite(beside)]
    bound = 1.15 * max(error_bound, min(known.max(initial=0.0), 3 * error_bound))
    return [-float(bound), float(bound)] if 0 < bound < np.inf else None


def _stacked(
    labels: Sequence[str], data: RunData, ranges: Sequence[list[float] | None] = ()
) -> dict[str, Any]:
    return stacked(labels, _span(data), data.outages, ranges)


def stacked(
    labels: Sequence[str],
    span: list[float],
    outages: Sequence[tuple[float, float]] = (),
    ranges: Sequence[list[float] | None] = (),
) -> dict[str, Any]:
    """Layout of one time axis under several rows; `outages` (start, duration) are shaded."""
    count = len(labels)
    gap = 0.035
    height = (1 - gap * (count - 1)) / count
    layout: dict[str, Any] = {
        "height": 130 + 135 * count,
        "xaxis": axis("time, s", anchor=f"y{count}" if count > 1 else "y", zeroline=False, range=span),
    }
    for place, label in enumerate(labels):
        top = 1 - place * (height + gap)
        made = axis(label, domain=[max(0.0, top - height), top], zeroline=True, zerolinecolor="#c3c9d2")
        if place < len(ranges) and ranges[place] is not None:
            made["range"] = ranges[place]
        layout[f"yaxis{place + 1}" if place else "yaxis"] = made
    layout["shapes"] = [
        {
            "type": "rect",
            "xref": "x",
            "yref": "paper",
            "y0": 0,
            "y1": 1,
            "layer": "below",
            "x0": start,
            "x1": start + duration,
            "fillcolor": OUTAGE,
            "line": {"width": 0},
        }
        for start, duration in outages
    ]
    return layout


def _span(data: RunData) -> list[float]:
    """The run's time from 0 to its last solution, s."""
    t = data.solution.column("t_s")
    return [0.0, float(t[-1])] if len(t) else [0.0, 1.0]


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis with its title, in the page's colours."""
    return {"title": {"text": title, "standoff": 8}, "gridcolor": GRID, "linecolor": "#c3c9d2"} | more
