"""When which task ran: a recorded window of each processor as bars in time."""

from __future__ import annotations

import numpy as np

from host.record.run_data import TaskTrace
from host.report.charts import Chart

COLOURS = ("#1c6dd0", "#e8710a", "#2b8a3e", "#9c36b5", "#0b7285", "#c0392b", "#846358", "#5c677d")

SHOWN_AT_FIRST_MS = 250.0
BARS_PER_TASK = 1500


def timeline(trace: TaskTrace) -> Chart:
    """One chart for one recorded window: a row for each task, a bar for each activation."""
    origin = float(trace.starts[0])
    length_ms = 1e3 * (float(trace.ends.max()) - origin)
    traces = []
    for place, name in enumerate(trace.names):
        mine = np.flatnonzero(trace.tasks == place)[:BARS_PER_TASK]
        colour = COLOURS[place % len(COLOURS)]
        starts = np.round((trace.starts[mine] - origin) * 1e3, 4)
        lengths = np.round((trace.ends[mine] - trace.starts[mine]) * 1e3, 4)
        traces.append(
            {
                "type": "bar",
                "orientation": "h",
                "name": name,
                "showlegend": False,
                "y": [name] * len(mine),
                "base": starts.tolist(),
                "x": lengths.tolist(),
                "marker": {"color": colour, "line": {"color": colour, "width": 1}},
                "hovertemplate": f"{name}: from %{{base:.3f}} ms, %{{x:.3f}} ms long<extra></extra>",
            }
        )
    layout = {
        "height": 130 + 34 * len(trace.names),
        "barmode": "overlay",
        "bargap": 0.35,
        "dragmode": "pan",
        "xaxis": {
            "title": {"text": f"ms from t = {origin:.3f} s", "standoff": 8},
            "range": [0, min(length_ms, SHOWN_AT_FIRST_MS)],
            "gridcolor": "#e6e9ee",
            "zeroline": False,
        },
        "yaxis": {"autorange": "reversed", "gridcolor": "#e6e9ee", "fixedrange": True, "automargin": True},
    }
    text = (
        f"Processor {trace.processor}, {length_ms:.0f} ms recorded; a bar lasts from the start of a task "
        "to its end, interruptions by more urgent tasks included. Drag to move along, scroll to zoom."
    )
    return Chart(f"timeline-{trace.processor}", f"Tasks of {trace.processor} in time", text, traces, layout)
