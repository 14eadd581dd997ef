"""What the configuration registers mean: rates, noise, formats, times (fact sheet sections 2 and 3).

All rates are halvings of 3200 Hz, so that time inside the chip is counted in ticks of 312.5 µs: rate code c
samples every 2^(15−c) ticks, the wake-up rates 8, 4, 2, 1 Hz every 400, 800, 1600, 3200 ticks.

Noise: 0.75 counts of 3.9 mg at 100 Hz, growing with the root of the rate, are 290 µg/√Hz over 100 Hz: the
noise bandwidth is the output rate, and no less than 100 Hz. In low power it is that of 1.8 counts: 570 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from boards.chips.adxl345.register_map import FULL_RES, JUSTIFY_LEFT, LOW_POWER

TICK_RATE_HZ = 3_200
STANDARD_GRAVITY = 9.80665
"""m/s² in one g."""

TURN_ON_NS = 1_100_000
"""From the write that starts measurement, and from waking, to the first sample: this and one period."""

LEAST_NOISE_HZ, LOW_POWER_NOISE_HZ = 100.0, 570.0
AVERAGED_TICKS = 32
"""Undecimated samples in one of 100 Hz, and of the slower rates, whose noise is no lower."""

_FULL_RESOLUTION_COUNTS_PER_G = 256.0
_FASTEST_CODES = (0xE, 0xF)

_SELF_TEST_G = (0.65, -0.65, 1.0)
"""At 2.5 V: the geometric middle of the limits."""
_SELF_TEST_FACTORS = ((2.0, 0.64, 0.80), (2.5, 1.0, 1.0), (3.3, 1.77, 1.47), (3.6, 2.11, 1.69))
"""Supply (V), factor of X and Y, factor of Z."""


def rate_period(bw_rate: int) -> int:
    """Ticks between two output samples."""
    return 1 << (15 - (bw_rate & 0x0F))


def wakeup_period(power_ctl: int) -> int:
    """Ticks between two samples in sleep mode."""
    return 400 << (power_ctl & 0x03)


def noise_bandwidth_hz(period: int, bw_rate: int) -> float:
    """Of the samples at a period."""
    if bw_rate & LOW_POWER:
        return LOW_POWER_NOISE_HZ
    return max(TICK_RATE_HZ / period, LEAST_NOISE_HZ)


@dataclass(frozen=True, slots=True)
class WordFormat:
    """How a sample becomes the 16 bits of its registers."""

    counts_per_g: float
    low: int
    high: int
    mask: int
    """Bits of the count that exist: the lowest one does not at the fastest rates."""
    shift: int


def word_format(data_format: int, bw_rate: int) -> WordFormat:
    """The format that DATA_FORMAT asks for at a rate."""
    code = data_format & 0x03
    full = bool(data_format & FULL_RES)
    bits = 10 + code if full else 10
    per_g = _FULL_RESOLUTION_COUNTS_PER_G if full else _FULL_RESOLUTION_COUNTS_PER_G / (1 << code)
    lowest_is_zero = bw_rate & 0x0F in _FASTEST_CODES and (full or code == 0)
    half = 1 << (bits - 1)
    shift = 16 - bits if data_format & JUSTIFY_LEFT else 0
    return WordFormat(per_g, -half, half - 1, ~1 if lowest_is_zero else ~0, shift)


def offset_g(register: int) -> float:
    """What an offset register adds: 1/64 g (15.6 mg) for each of its signed counts."""
    return (register - 256 if register & 0x80 else register) / 64.0


def self_test_g(supply_v: float) -> tuple[float, float, float]:
    """The deflection at a supply voltage."""
    table = _SELF_TEST_FACTORS
    for (low, xy_low, z_low), (high, xy_high, z_high) in pairwise(table):
        if supply_v <= high:
            part = (supply_v - low) / (high - low)
            xy, z = xy_low + part * (xy_high - xy_low), z_low + part * (z_high - z_low)
            break
    x_g, y_g, z_g = _SELF_TEST_G
    return x_g * xy, y_g * xy, z_g * z


def supply_effect(supply_v: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Factors and offsets (g) that a supply other than 2.5 V brings: at 3.3 V X and Y have 265 counts per g
    and +25 mg, Z has −20 mg; linear in between."""
    part = (supply_v - 2.5) / 0.8
    gain = 1.0 + part * (265.0 / 256.0 - 1.0)
    return (gain, gain, 1.0), (0.025 * part, 0.025 * part, -0.020 * part)
