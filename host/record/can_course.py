"""When the frames of a CAN bus came, second by second: little enough to keep for a run of any length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class CanCourse:
    """The frames of one identifier on one bus."""

    bus: str
    identifier: int
    """Bit 31: a 29-bit identifier. None of those beyond `host.run.can_rhythm.MOST_IDENTIFIERS` is kept."""
    frames: NDArray[np.int64]
    """How many ended in each second of the run."""
    gaps: NDArray[np.float64]
    """The longest time without one that ended in each second (s); the last lasts until the end of the run."""
