"""When the receiver's epochs were really valid, from the times that they tell.

In every world the receiver's clock runs with virtual time; only a fault of kind gnss-time-jump makes an epoch
tell another time. `host.run.surroundings.ReceiverSight` remembers the same while a run is on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch
from host.run.surroundings import DAY_MS
from host.sim.gnss.schedule import Glitch

MS = 1_000_000
NEAREST_NS = 300_000_000_000
"""An epoch that the board dates further off than this from what it tells did not know its time."""


@dataclass(frozen=True)
class ReceiverTimes:
    """Of one receiver: its epoch at virtual time 0, and the faults that struck it."""

    at_zero: GnssEpoch
    glitches: Sequence[Glitch]

    def validity_ns(
        self, time_of_day_ms: NDArray[np.float64], otherwise_ns: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """True validity of epochs told by their UTC time of day; `otherwise_ns` where that is not known."""
        pairs = zip(time_of_day_ms.tolist(), otherwise_ns.tolist(), strict=True)
        return np.array([self._validity(int(told), other) for told, other in pairs], dtype=np.int64)

    def _validity(self, told_ms: int, otherwise_ns: int) -> int:
        """Of the instants at which an epoch would tell this, the one nearest to where the board dated it."""
        shifts = {0, *(glitch.time_offset_ns for glitch in self.glitches)}
        instants = [(self._instant(told_ms, shift_ns, otherwise_ns), shift_ns) for shift_ns in shifts]
        possible = [ns for ns, shift_ns in instants if ns >= 0 and self._shift_ns(ns) == shift_ns]
        nearest = min(possible, key=lambda ns: abs(ns - otherwise_ns), default=otherwise_ns)
        return nearest if abs(nearest - otherwise_ns) < NEAREST_NS else otherwise_ns

    def _instant(self, told_ms: int, shift_ns: int, near_ns: int) -> int:
        """When a clock that is off by `shift_ns` shows that time of the day, on the day around `near_ns`."""
        day_ns = DAY_MS * MS
        instant = (told_ms * MS - self._zero_ns - shift_ns) % day_ns
        return instant + round((near_ns - instant) / day_ns) * day_ns

    def _shift_ns(self, valid_ns: int) -> int:
        return sum(glitch.time_offset_ns for glitch in self.glitches if glitch.window.holds(valid_ns))

    @property
    def _zero_ns(self) -> int:
        """UTC time at virtual time 0, from any midnight on."""
        return self.at_zero.gps_time_ns - self.at_zero.leap_seconds * 1000 * MS
