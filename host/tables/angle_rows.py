"""One row of the document's tables, done again: what was measured in the hold, and how far that is off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.tables.angle_errors import rotation_between, wrapped
from host.tables.document import DocumentRow
from host.tables.positions import STEEP_DEG

Array = NDArray[np.float64]
IDEAL, CHIP = "ideal", "chip"
FEEDS = (IDEAL, CHIP)
GOAL_DEG = {IDEAL: 0.05, CHIP: 0.5}


@dataclass(frozen=True, slots=True)
class AngleRow:
    """Ours beside the document's."""

    document: DocumentRow
    feed: str
    arithmetic: str
    compensated: bool
    """Whether the board's drift compensation was on; with exact rates there is none."""
    measured_deg: tuple[float, float, float]
    """Pitch, roll, yaw where each was farthest off."""
    error_deg: tuple[float, float, float]
    """The largest in the hold, wrapped."""
    rotation_deg: float
    """The largest total rotation between measured and true attitude in the hold."""

    @property
    def is_steep(self) -> bool:
        """Whether yaw and roll are not told apart: scored by the total rotation."""
        return self.document.axis == "pitch" and abs(self.document.angle_deg) >= STEEP_DEG

    @property
    def worst_deg(self) -> float:
        """What is held against the goal."""
        return self.rotation_deg if self.is_steep else max(self.error_deg)

    @property
    def goal_deg(self) -> float:
        """Below which the row must stay."""
        return GOAL_DEG[self.feed]

    @property
    def met(self) -> bool:
        """Whether it does; a figure that is none does not."""
        return self.worst_deg < self.goal_deg


def scored(document: DocumentRow, how: tuple[str, str, bool], measured: Array, truth: Array) -> AngleRow:
    """Of the solutions in the hold: (n, 3) pitch, roll, yaw in rad, and the true ones at the same times.

    `how`: feed, arithmetic, whether compensated. ValueError when there are no solutions.
    """
    if not len(measured):
        raise ValueError("no solutions in the hold")
    off = wrapped(measured - truth)
    worst = np.argmax(np.abs(off), axis=0)
    shown, errors = [], []
    for angle, place in enumerate(worst):
        shown.append(float(np.degrees(truth[place, angle] + off[place, angle])))
        errors.append(float(np.degrees(abs(off[place, angle]))))
    rotation = float(np.degrees(np.max(rotation_between(measured, truth))))
    pitch, roll, yaw = shown
    return AngleRow(document, *how, (pitch, roll, yaw), (errors[0], errors[1], errors[2]), rotation)
