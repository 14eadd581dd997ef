"""Whether seven accelerometers on one rigid body agree: which of them is turned, or has run away.

All sit alike, so all feel the same force but for what turning makes at the end of an arm (ω² l: 0.06 g at
90°/s, 0.25 m). Ten times a second the newest samples go into running means. A chip of which an axis is
further from the median of all than offsets and sensitivities allow is at odds with the others once that has
lasted a second, and no longer after another second of agreement. When more than two are far off, it is the
motion.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins.accelerations import CHIPS
from firmware.drivers.adxl345_sample import SAMPLE_LENGTH
from firmware.numerics.dialect import entry_point, kernel

AXES = 3
FARTHEST = 102 << 8
"""0.4 g, in 1/256 of a count: offsets of two chips (0.15 g each) and 10 % of sensitivity."""
HOLD = 10
"""Looks."""
MOST = 2
BEGUN = CHIPS * AXES
WORK = BEGUN + 1
SIZE = WORK + CHIPS
SIGN = np.int64(0x8000)
ONE = np.int64(1)


@kernel("int64(uint8[::1], int64, int64[::1])")
def chips_far_off(raw, known, means):
    """Bits of those that are far from the median, after the means have taken the newest samples in.

    `raw`: a sample of each chip as its driver has it; `known`: bits of the chips that are compared;
    `means`: SIZE numbers, at first zeros."""
    for chip in range(np.int32(CHIPS)):
        for axis in range(np.int32(AXES)):
            place = chip * SAMPLE_LENGTH + 1 + 2 * axis
            count = ((np.int64(raw[place + 1]) << 8) | np.int64(raw[place])) ^ SIGN
            value = (count - SIGN) << 8
            k = chip * AXES + axis
            means[k] = value if means[BEGUN] == 0 else means[k] + ((value - means[k]) >> 2)
    means[BEGUN] = ONE
    far = np.int64(0)
    for axis in range(np.int32(AXES)):
        far |= _far_along(known, means, axis)
    return far


@kernel
def _far_along(known, means, axis):
    """The same along one axis; none when fewer than three chips are known."""
    count = np.int32(0)
    for chip in range(np.int32(CHIPS)):
        if (known >> chip) & ONE != 0:
            value = means[chip * AXES + axis]
            k = count
            while k > 0 and means[WORK + k - 1] > value:
                means[WORK + k] = means[WORK + k - 1]
                k -= 1
            means[WORK + k] = value
            count += 1
    far = np.int64(0)
    if count < AXES:
        return far
    middle = means[WORK + (count >> 1)]
    for chip in range(np.int32(CHIPS)):
        if (known >> chip) & ONE != 0 and abs(means[chip * AXES + axis] - middle) > FARTHEST:
            far |= ONE << chip
    return far


class Agreement:
    """Looks from the background, ten times a second."""

    def __init__(self, raw: NDArray[np.uint8]) -> None:
        """`raw`: the newest samples, as `Accelerometers` keeps them."""
        self.at_odds = 0
        """Bit k: chip k + 1."""
        self._far_off = entry_point(chips_far_off)
        self._raw = raw
        self._means = np.zeros(SIZE, np.int64)
        self._looks = [0] * CHIPS
        """How long each has been what it is not called."""

    def look(self, known: int) -> int:
        """Bits of the chips at odds with the others, of those that are `known` to give samples."""
        far = self._far_off(self._raw, known, self._means)
        if far.bit_count() > MOST:
            return self.at_odds
        differ = (far ^ self.at_odds) & known
        for chip in range(CHIPS):
            self._looks[chip] = self._looks[chip] + 1 if differ >> chip & 1 else 0
            if self._looks[chip] >= HOLD:
                self._looks[chip] = 0
                self.at_odds ^= 1 << chip
        return self.at_odds
