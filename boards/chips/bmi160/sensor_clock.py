"""The 25.6 kHz sensor time clock and its exact arithmetic (fact sheet sections 3 and 7).

Every sample instant hangs on this clock: an ODR of 100 Hz samples whenever bit 8 of the counter toggles,
that is every 256 ticks. With a clock that is fast by e parts per billion the n-th tick falls at

    t_n = t_0 + ⌊n · 10¹⁸ / (25600 · (10⁹ + e))⌋ ns

computed from its count, so that nothing accumulates. Both numbers are reduced by their common divisor.
"""

from __future__ import annotations

from math import gcd

import numpy as np
from numpy.typing import NDArray

from boards.chips.bmi160.block_kernels import fill_instants

TICK_RATE_HZ = 25_600
BILLION = 1_000_000_000
COUNTER_MASK = 0xFF_FFFF
"""The counter has 24 bits and wraps every 655.36 s."""


class SensorClock:
    """One oscillator from its start. `error_ppb` > 0: it runs fast."""

    __slots__ = ("denominator", "numerator", "start_ns")

    def __init__(self, start_ns: int, error_ppb: int = 0) -> None:
        if not -100_000_000 <= error_ppb <= 100_000_000:
            raise ValueError(
                f"clock error of {error_ppb} ppb; it must lie within ±10 %, e.g. 5_000_000 for +0.5 %"
            )
        numerator = BILLION * BILLION
        denominator = TICK_RATE_HZ * (BILLION + error_ppb)
        common = gcd(numerator, denominator)
        self.start_ns = start_ns
        self.numerator = numerator // common
        self.denominator = denominator // common

    def instant(self, tick: int) -> int:
        """Time (ns) at which the counter reaches `tick`."""
        return self.start_ns + tick * self.numerator // self.denominator

    def tick(self, time_ns: int) -> int:
        """The counter, not wrapped, at a time; 0 before the start."""
        elapsed = time_ns - self.start_ns
        if elapsed < 0:
            return 0
        return ((elapsed + 1) * self.denominator - 1) // self.numerator

    def grid(self, first_tick: int, period: int, count: int) -> NDArray[np.int64]:
        """Instants (ns) of `count` ticks from `first_tick` on, `period` apart.

        `count · period` must stay below 200,000 ticks.
        """
        whole, rest = divmod(first_tick * self.numerator, self.denominator)
        instants = np.empty(count, np.int64)
        fill_instants(self.start_ns + whole, rest, period * self.numerator, self.denominator, instants)
        return instants
