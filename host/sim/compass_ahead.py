"""A compass's samples worked out in blocks, at the instants that the chip expects: a tenth of the time.

What was foreseen is what would have been felt without foreseeing: noise that belongs to samples which nobody
came to ask for is drawn again.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.sim.compass import FeltCompass

Array = NDArray[np.float64]


class CompassAhead:
    """Implements `boards.chips.world.CompassWorld`, with `foresee`."""

    def __init__(self, compass: FeltCompass) -> None:
        self.compass = compass
        """What tells without foreseeing."""
        self._times: list[int] = []
        self._rows: Array = np.empty((0, 7))
        self._asked = 0
        """Of the samples foreseen."""
        self._before: Any = None
        """The sources of noise as they were before those were drawn."""

    def foresee(self, times_ns: NDArray[np.int64]) -> None:
        """At these rising times samples will probably be asked for, one after the other."""
        self.forget()
        self._before = self.compass.noise()
        self._rows = self.compass.sample(times_ns)
        self._times = times_ns.tolist()

    def sample(self, times_ns: NDArray[np.int64]) -> Array:
        """Force (3), field (3), temperature at rising times."""
        k = self._asked
        if len(times_ns) == 1 and k < len(self._times) and times_ns[0] == self._times[k]:
            self._asked = k + 1
            return self._rows[k : k + 1]
        self.forget()
        return self.compass.sample(times_ns)

    def forget(self) -> None:
        """The world has changed, or other times are asked for than were foreseen."""
        times, asked = self._times, self._asked
        self._times, self._asked = [], 0
        if asked < len(times):
            self.compass.set_noise(self._before)
            if asked:
                self.compass.sample(np.array(times[:asked], np.int64))
