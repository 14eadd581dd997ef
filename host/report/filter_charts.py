"""Filters side by side, each with its errors, like figures 5.1 to 5.3 of the document that gfsins follows."""

from __future__ import annotations

from typing import Any

from host.record.run_data import RunData
from host.report.charts import FUSED, GNSS, OUTAGE_LINE, Chart, column, line, on_row, stacked

FILTER_SERIES = "filter"
NAMES = ("Compass filter", "GPS filter")
"""In the order of FILTER frames."""
TEXTS = (
    "Attitude, velocity and position of the filter that has the compass alone, solution minus truth. Attitude"
    " converges, velocity and position run away.",
    "The same of the filter that has GPS alone. Velocity, position and tilt converge, heading runs away.",
)
FUSED_TEXT = "The same of the fusion of both, which is the board's solution."
RESET_TEXT = " With resets each begins anew from the fusion; profile no-reset shows it by itself."
ROWS = (
    ("attitude, °", ("roll", "pitch", "yaw"), "error_{}_deg"),
    ("velocity, m/s", ("north", "east", "down"), "error_v_{}_mps"),
    ("position, m", ("north", "east", "down"), "error_{}_m"),
)
COLOURS = (FUSED, GNSS, OUTAGE_LINE)


def filter_charts(data: RunData) -> list[Chart]:
    """One chart a filter and one of the fusion; none of a board with one filter."""
    if not data.filters:
        return []
    sources = [
        (f"{FILTER_SERIES}{k}", NAMES[k] if k < len(NAMES) else f"Filter {k}", TEXTS[k : k + 1])
        for k, series in enumerate(data.filters)
        if len(series)
    ]
    made = [_chart(data, name, title, "".join(text) + RESET_TEXT) for name, title, text in sources]
    return [*made, _chart(data, "solution", "Fused", FUSED_TEXT)]


def _chart(data: RunData, series: str, title: str, text: str) -> Chart:
    time = column(f"{series}.t_s")
    traces: list[dict[str, Any]] = []
    for place, (_, names, wanted) in enumerate(ROWS):
        for name, colour in zip(names, COLOURS, strict=True):
            trace = line(time, column(f"{series}.{wanted.format(name)}"), name, colour)
            traces.append(on_row(trace, place) | {"showlegend": place < 2, "legendgroup": f"{place}{name}"})
    t = data.solution.column("t_s")
    span = [0.0, float(t[-1])] if len(t) else [0.0, 1.0]
    layout = stacked([label for label, _, _ in ROWS], span, data.outages)
    return Chart(f"{series}-errors", f"{title}: errors", text, traces, layout, in_time=True)
