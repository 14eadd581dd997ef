"""Scale and offset of the nine accelerations: what the FPGA keeps in its flash and applies at every tick.

Scales are words of 0.5 mg for a count of 1/256 g, in units of 2⁻¹⁶; offsets are words. The limits are wider
than what the data sheet of the ADXL345 leaves open (sensitivity ±10 %, zero ±0.25 g): beyond them a number is
a slip.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from firmware.apps.gfsins.accelerations import NOMINAL_SCALE

AXES: Final = 9
LEAST_SCALE: Final = NOMINAL_SCALE * 85 // 100
LARGEST_SCALE: Final = NOMINAL_SCALE * 115 // 100
LARGEST_OFFSET: Final = 800
"""0.4 g."""
WORD: Final = 0.5e-3 * 9.80665
"""m/s² of a word of the packet."""


def correction_of(response: float, offset: float) -> tuple[int, int] | None:
    """Scale 1/h and offset b/h of an accelerometer that reads h f + b (m/s²); None: beyond the limits."""
    if not response > 0.0:
        return None
    scale, words = round(NOMINAL_SCALE / response), round(offset / response / WORD)
    return (scale, words) if LEAST_SCALE <= scale <= LARGEST_SCALE and abs(words) <= LARGEST_OFFSET else None


class Corrections:
    """Of both modes; outlives a reset of the processor."""

    def __init__(self) -> None:
        self.scales = np.full(AXES, NOMINAL_SCALE, np.int64)
        self.offsets = np.zeros(AXES, np.int64)

    def set_scale(self, axis: int, scale: int) -> bool:
        """Axis 0 is A1. False: outside the limits, nothing has changed."""
        if not 0 <= axis < AXES or not LEAST_SCALE <= scale <= LARGEST_SCALE:
            return False
        self.scales[axis] = scale
        return True

    def set_offset(self, axis: int, offset: int) -> bool:
        """False: outside the limits, nothing has changed."""
        if not 0 <= axis < AXES or abs(offset) > LARGEST_OFFSET:
            return False
        self.offsets[axis] = offset
        return True
