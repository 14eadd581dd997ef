"""What a burst tells besides motion, in integers (fact sheet section 3).

supply 2.418 mV,  temperature 25 °C + 0.136 K,  pressure 0.0003125 mbar,  field 50 nT,  ADC 0.806 mV a count
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware.nav.attitude.burst_words import BARO, MAGN

DATA_12, DATA_14 = 0x0FFF, 0x3FFF


def ambient(words: Sequence[int]) -> tuple[int, int, int, int, int]:
    """(supply in mV, temperature in 0.01 °C, pressure in Pa, magnitude of the field in nT, ADC in mV)."""
    pressure_counts = (words[BARO] & DATA_14) << 8 | words[BARO + 1] & 0xFF
    squares = sum(_signed(words[MAGN + n], 14) ** 2 for n in range(3))
    return (
        (words[0] & DATA_12) * 2418 // 1000,
        2500 + _signed(words[BARO + 2], 12) * 136 // 10,
        pressure_counts // 32,
        50 * math.isqrt(squares),
        (words[BARO + 3] & DATA_12) * 806 // 1000,
    )


def _signed(word: int, bits: int) -> int:
    half = 1 << (bits - 1)
    return ((word & (2 * half - 1)) ^ half) - half
