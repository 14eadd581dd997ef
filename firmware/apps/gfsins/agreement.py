"""Whether the seven accelerometers agree, and for how long they have not.

All sit alike on one rigid body, so all feel the same force but for what turning makes at the end of an arm
(ω² l: 0.06 g at 90°/s, 0.25 m). Ten times a second the newest samples are compared (`agreement_step`). A chip
that has been far off for a second is at odds with the others, and no longer after another second of
agreement. When more than two are far off, it is the motion.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins.accelerations import CHIPS
from firmware.apps.gfsins.agreement_step import SIZE, chips_far_off
from firmware.numerics.dialect import entry_point

HOLD = 10
"""Looks."""
MOST = 2


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
