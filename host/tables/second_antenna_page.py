"""The table of the second antenna for people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from host.report.html import document, table
from host.report.numbers import NONE
from host.report.summary import MET, NOT_MET, Section
from host.tables.second_antenna import AFTER_S, HEADING_LIMIT_DEG, CompassRow, HeadingRow

TITLE = "Heading with and without the second antenna"
COMPASS_TITLE = "Gyro-compass at rest"


def heading_section(rows: Sequence[HeadingRow]) -> Section:
    """One row a run."""
    columns = (
        "", "second antenna", "heading RMS, °", "largest, °", "pitch RMS, °", "receiver's heading RMS, °",
        "begins, s", "verdict",
    )  # fmt: skip
    shown = [
        (
            row.motion,
            row.attitude,
            f"{row.heading_rms:.4f}",
            f"{row.heading_max:.4f}",
            f"{row.pitch_rms:.4f}",
            f"{row.receiver_rms:.4f}",
            f"{row.begins_s:.0f}",
            {True: MET, False: NOT_MET, None: NONE}[row.met],
        )
        for row in rows
    ]
    note = (
        f"From {AFTER_S:g} s behind the beginning of navigation on. With the second antenna at most"
        f" {HEADING_LIMIT_DEG:g}°, and less than the receiver's own."
    )
    return Section(TITLE, columns, tuple(shown), 2, note)


def compass_section(rows: Sequence[CompassRow]) -> Section:
    """1 σ against time."""
    shown = [(f"{row.after_s}", f"{row.sigma:.2f}", f"{row.error:+.2f}") for row in rows]
    return Section(
        COMPASS_TITLE, ("after, s", "1 σ, °", "error, °"), tuple(shown), 0, "As the board tells it."
    )


def page(rows: Sequence[HeadingRow], compass: Sequence[CompassRow]) -> str:
    """One file that opens offline."""
    body = [
        f"<header><h1>{TITLE}</h1></header>",
        table(heading_section(rows)),
        table(compass_section(compass)),
    ]
    return document(TITLE, body, "")


def to_dict(row: HeadingRow) -> dict[str, Any]:
    """For JSON."""
    return asdict(row) | {"met": row.met}
