"""Instants of a sample clock of any rate, as whole nanoseconds: t_k = ⌊k · 10⁹ / rate⌋, never accumulated."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

NS = 1_000_000_000


def instants(rate_hz: Fraction, first: int, count: int) -> NDArray[np.int64]:
    """The instants first … first + count − 1 in ns."""
    step = NS * rate_hz.denominator
    base, rest = divmod(first * step, rate_hz.numerator)
    offsets: NDArray[np.int64] = (rest + np.arange(count, dtype=np.int64) * step) // rate_hz.numerator
    return base + offsets


def count_within(rate_hz: Fraction, duration_ns: int) -> int:
    """How many whole sample intervals the duration holds."""
    return int(duration_ns * rate_hz / NS)
