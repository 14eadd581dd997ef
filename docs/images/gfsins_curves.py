"""Draws gfsins-board.png, gfsins-filters.png and gfsins-arms.png. Needs matplotlib.

navtwin table arms --json arms.json
python docs/images/gfsins_curves.py arms.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from firmware.nav.gyro_free.filters import FilterConfig
from host.record.result import RunRequest
from host.run.runner import run
from host.tables.chapter5 import chapter5
from host.tables.federated_run import Errors, run_federated, run_single

Array = NDArray[np.float64]
TITLES = ("compass filter (figure 5.1)", "GPS filter (figure 5.2)", "federated (figure 5.3)")
ROWS = (
    ("attitude error, °", ("roll", "pitch", "heading")),
    ("velocity error, m/s", ("north", "east", "down")),
    ("position error, m", ("north", "east", "down")),
)
COLUMNS = (
    ("error_roll_deg", "error_pitch_deg", "error_yaw_deg"),
    ("error_v_north_mps", "error_v_east_mps", "error_v_down_mps"),
    ("error_north_m", "error_east_m", "error_down_m"),
)
COLOURS = ("#1c6dd0", "#e8710a", "#c0392b")
Curves = tuple[Array, list[Array]]
"""Times, and (n, 3) errors of each row."""


def of_the_board() -> list[Curves]:
    """Scenario chapter5 with the document's own reset mode."""
    result = run(RunRequest("gfsins", "chapter5", profile="no-reset", capture=False))
    assert result.data is not None
    sources = (*result.data.filters, result.data.solution)
    return [
        (one.column("t_s"), [np.column_stack([one.column(name) for name in names]) for names in COLUMNS])
        for one in sources
    ]


def of_the_table() -> list[Curves]:
    """The filters by themselves, in the conditions of `navtwin table federated`, first seed."""
    feed = chapter5(300, 1)
    config = FilterConfig(reset="no_reset")
    found = run_single(feed, config, True, False), run_single(feed, config, False, True)
    return [_curves(one) for one in (*found, run_federated(feed, config).master)]


def _curves(errors: Errors) -> Curves:
    times = np.arange(1.0, len(errors.position) + 1.0)
    return times, [np.degrees(errors.attitude), errors.velocity, errors.position]


def draw_chapter(curves: list[Curves], name: str) -> None:
    """Three figures side by side."""
    figure, axes = plt.subplots(3, 3, figsize=(12.0, 8.0), sharex=True)
    for column, (times, parts) in enumerate(curves):
        axes[0, column].set_title(TITLES[column], fontsize=10)
        for row, (label, names) in enumerate(ROWS):
            shown = axes[row, column]
            for values, told, colour in zip(parts[row].T, names, COLOURS, strict=True):
                shown.plot(times, values, color=colour, linewidth=0.9, label=told)
            shown.grid(color="#e6e9ee")
            if column == 0:
                shown.set_ylabel(label)
            if column == 2 and row < 2:
                shown.legend(fontsize=8)
        axes[2, column].set_xlabel("time, s")
    _save(figure, name)


def draw_arms(rows: list[dict[str, Any]], name: str) -> None:
    """What the table of arms tells."""
    figure, shown = plt.subplots(figsize=(9.5, 4.2))
    arms = [row["arm_m"] for row in rows]
    lines = (
        ("heading_without_compass_deg", "heading after 10 s without compass, °"),
        ("rate_one_axis_dps", "rate by itself, a minute about one axis, °/s"),
        ("rate_all_axes_dps", "rate by itself, a minute about all axes, °/s"),
        ("heading_deg", "heading with compass, °"),
        ("tilt_deg", "tilt with compass and GPS, °"),
        ("drift_m", "position after 60 s without GPS, m"),
    )
    for key, label in lines:
        shown.loglog(arms, [row[key] for row in rows], marker="o", markersize=3, linewidth=1.1, label=label)
    shown.set_xticks(arms, [f"{arm:g}" for arm in arms])
    shown.set_xlabel("arm, m")
    shown.grid(color="#e6e9ee")
    shown.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.02, 0.5))
    _save(figure, name)


def _save(figure: Any, name: str) -> None:
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name(name), dpi=90, metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    draw_arms(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))["rows"], "gfsins-arms.png")
    draw_chapter(of_the_table(), "gfsins-filters.png")
    draw_chapter(of_the_board(), "gfsins-board.png")
