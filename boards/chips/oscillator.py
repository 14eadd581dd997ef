"""A chip's own oscillator: exact instants of its ticks.

With a clock that is fast by e parts per billion the n-th tick of a rate of r falls at

    t_n = t_0 + ⌊n · 10¹⁸ / (r · (10⁹ + e))⌋ ns

computed from its count, so that nothing accumulates. Both numbers are reduced by their common divisor.
"""

from __future__ import annotations

from math import gcd

import numpy as np
from numba import njit
from numpy.typing import NDArray

BILLION = 1_000_000_000
_INT64_END = 1 << 63


@njit(cache=True, error_model="numpy")
def fill_instants(start_ns: int, rest: int, step: int, denominator: int, instants: NDArray[np.int64]) -> None:
    """instants[i] = start_ns + (rest + i·step) // denominator, all positive."""
    for i in range(len(instants)):
        instants[i] = start_ns + (rest + i * step) // denominator


class Oscillator:
    """One oscillator from its start. `error_ppb` > 0: it runs fast."""

    __slots__ = ("denominator", "numerator", "start_ns")

    def __init__(self, tick_rate_hz: int, start_ns: int, error_ppb: int = 0) -> None:
        if not -100_000_000 <= error_ppb <= 100_000_000:
            raise ValueError(
                f"clock error of {error_ppb} ppb; it must lie within ±10 %, e.g. 5_000_000 for +0.5 %"
            )
        numerator = BILLION * BILLION
        denominator = tick_rate_hz * (BILLION + error_ppb)
        common = gcd(numerator, denominator)
        self.start_ns = start_ns
        self.numerator = numerator // common
        self.denominator = denominator // common

    def pull(self, time_ns: int, tick_rate_hz: int, error_ppb: int) -> None:
        """From `time_ns` on run with another error; the tick under way still lasts as long as it would have,
        or, of a clock that is now faster, less."""
        tick = self.tick(time_ns)
        other = Oscillator(tick_rate_hz, 0, error_ppb)
        kept = self.instant(tick + 1) - other.instant(tick + 1)
        self.start_ns = min(kept, time_ns - other.instant(tick))
        self.numerator, self.denominator = other.numerator, other.denominator

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
        """Instants (ns) of `count` ticks from `first_tick` on, `period` apart."""
        step = period * self.numerator
        whole, rest = divmod(first_tick * self.numerator, self.denominator)
        if rest + count * step >= _INT64_END:
            return np.array([self.instant(first_tick + i * period) for i in range(count)], np.int64)
        instants = np.empty(count, np.int64)
        fill_instants(self.start_ns + whole, rest, step, self.denominator, instants)
        return instants
