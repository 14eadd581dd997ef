"""What the document measured (source 001, section 5.3 and appendices 2 to 4)."""

from __future__ import annotations

import functools
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

AXES = ("pitch", "roll", "yaw")
LARGEST_ERROR_DEG = 1.0
"""What the document states for all rows."""


@dataclass(frozen=True, slots=True)
class DocumentRow:
    """One position of the dividing table; triples are pitch, roll, yaw, all in degrees."""

    axis: str
    angle_deg: float
    """To which the axis was turned; the other two stood at 0."""
    measured_deg: tuple[float, float, float]
    error_deg: tuple[float, float, float]
    """Absolute, as printed."""

    @property
    def worst_deg(self) -> float:
        """The largest of the three printed errors."""
        return max(self.error_deg)


@dataclass(frozen=True, slots=True)
class DocumentDrift:
    """Errors after a fast turn and a stop."""

    yaw_deg: float
    after_s: float
    drift_deg: tuple[float, float, float]
    """Pitch, roll, yaw."""


def document_rows(axis: str) -> tuple[DocumentRow, ...]:
    """All positions of an axis, by rising angle. KeyError for what is no axis."""
    return tuple(
        DocumentRow(axis, float(row[0]), (row[1], row[2], row[3]), (row[4], row[5], row[6]))
        for row in _read()[axis]["rows"]
    )


def document_drift() -> DocumentDrift:
    """The document's drift test."""
    found = _read()["drift"]
    drift = (found["pitch_deg"], found["roll_deg"], found["yaw_drift_deg"])
    return DocumentDrift(found["yaw_deg"], found["after_s"], drift)


@functools.cache
def _read() -> dict[str, Any]:
    text = (files("host.tables") / "document_angles.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
