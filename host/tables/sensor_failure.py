"""A sub-filter's sensor fails for a while: what is told of it, whether that is good, and the table of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from host.report.numbers import NONE, number
from host.report.summary import MET, NOT_MET, Section

BOUNDED_M, BOUNDED_DEG = 100.0, 5.0
"""The global solution while one sensor fails for 60 s."""
RECOVERED_WITHIN_S = 30


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorFailure:
    """One failure of 60 s."""

    name: str
    cause: str
    """What it was isolated for."""
    detected_s: float | None
    """After it began; None: never."""
    recovered_s: float | None
    """After it ended."""
    worst_position_m: float
    """From the beginning of the failure to the end of the run; of a board horizontal."""
    worst_heading_deg: float
    others_isolated: bool = False
    """A sound sensor was isolated, too."""

    @property
    def met(self) -> bool:
        """Detected, isolated, recovered, the rest in bounds."""
        if self.others_isolated:
            return False
        if self.detected_s is None or self.recovered_s is None or self.recovered_s > RECOVERED_WITHIN_S:
            return False
        return self.worst_position_m < BOUNDED_M and self.worst_heading_deg < BOUNDED_DEG

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "failure": self.name,
            "seen_as": self.cause,
            "isolated_after_s": self.detected_s,
            "trusted_after_s": self.recovered_s,
            "worst_position_m": self.worst_position_m,
            "worst_heading_deg": self.worst_heading_deg,
            "met": self.met,
        }


def failure_section(title: str, note: str, rows: Sequence[SensorFailure]) -> Section:
    """One row a failure."""
    cells = [
        (
            row.name,
            row.cause,
            _seconds(row.detected_s),
            _seconds(row.recovered_s),
            number(row.worst_position_m),
            f"{row.worst_heading_deg:.3f}",
            MET if row.met else NOT_MET,
        )
        for row in rows
    ]
    columns = (
        "for 60 s", "seen as", "isolated after, s", "trusted again after, s", "worst position, m",
        "worst heading, °", "verdict",
    )  # fmt: skip
    return Section(title, columns, tuple(cells), 2, note)


def _seconds(value: float | None) -> str:
    return NONE if value is None else number(value)
