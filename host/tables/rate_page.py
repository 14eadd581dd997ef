"""The table of rate methods for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import Any

from host.report.html import document, table
from host.report.numbers import counted
from host.report.summary import MET, NOT_MET, Section
from host.tables.rate_methods import ALLOWED, METHODS, RateRow

TITLE = "Angular rate from nine accelerometers"
NAMES = {
    "integration": "integration",
    "square_root": "square root",
    "differential": "differential (3.4-3.6)",
    "fused": "fused (ours)",
}


def section(rows: Sequence[RateRow], arm: float, duration_s: float, seeds: int) -> Section:
    """One row a rotation and kind of sensors, one column a method."""
    cells = [
        (row.sensors, row.rotation, *(_degrees(row.error[method]) for method in METHODS), _verdict(row))
        for row in rows
    ]
    columns = ("sensors", "rotation", *(f"{NAMES[method]}, °/s" for method in METHODS), "verdict")
    note = (
        f"RMS error of the rate over {duration_s:g} s, three axes together, {counted(seeds, 'seed')}, arms of"
        f" {arm:g} m. Fused must be within {ALLOWED:g} times the best of the other three, and the best with"
        " noise about all axes."
    )
    return Section(TITLE, columns, tuple(cells), 2, note)


def _degrees(rate: float) -> str:
    return f"{math.degrees(rate):.3g}" if math.isfinite(rate) else "no number"


def _verdict(row: RateRow) -> str:
    return MET if row.met else NOT_MET


def to_dict(row: RateRow) -> dict[str, Any]:
    """For JSON."""
    return {
        "sensors": row.sensors,
        "rotation": row.rotation,
        "rms_dps": {method: math.degrees(error) for method, error in row.error.items()},
        "must_be_best": row.must_win,
        "met": row.met,
    }


def page(shown: Section) -> str:
    """One file that opens offline."""
    return document(TITLE, [f"<header><h1>{escape(TITLE)}</h1></header>", table(shown)], "")
