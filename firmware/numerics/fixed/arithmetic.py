"""Numbers in Q formats: value = integer · 2⁻ⁿ, 32 bits wide where they are kept, products 64 bits wide.

    rounding      halves up: half of the last place is added before the arithmetic shift to the right
    saturation    a result beyond 32 bits becomes the nearest end, and is counted

Kernels take and return int64 so that NumPy and numba agree on the width; every number that is kept goes
through `saturated` or is bounded by what the caller states. Products of two 32-bit numbers, and sums of two
such products, fit into 63 bits.
"""

import numpy as np

from firmware.numerics.dialect import kernel

LARGEST = (1 << 31) - 1
SMALLEST = -(1 << 31)


def in_q(value: float, bits: int) -> int:
    """The constant `value` in Q format with `bits` fraction bits, for use when a module is loaded.

    ValueError when it does not fit into 32 bits.
    """
    number = round(value * 2.0**bits)
    if not SMALLEST <= number <= LARGEST:
        raise ValueError(f"{value!r} does not fit into Q{bits}: ±{2.0 ** (31 - bits):g}")
    return number


@kernel
def rounded_shift(x, bits):
    """x · 2^(−bits), halves up; 1 ≤ bits ≤ 62, |x| < 2⁶²."""
    return (x + (np.int64(1) << (bits - 1))) >> bits


@kernel
def product(a, b, bits):
    """a · b · 2^(−bits), halves up; |a · b| < 2⁶²."""
    return rounded_shift(a * b, bits)


@kernel("int64(int64, int64[::1], int64)")
def saturated(x, counters, place):
    """x, or the nearest end of 32 bits; `counters[place]` counts how often that was needed."""
    if x > LARGEST:
        counters[place] += 1
        return np.int64(LARGEST)
    if x < SMALLEST:
        counters[place] += 1
        return np.int64(SMALLEST)
    return x


@kernel("int64(int64, int64, int64[::1], int64)")
def limited(x, limit, counters, place):
    """x, or ±limit, counted likewise."""
    if x > limit:
        counters[place] += 1
        return limit
    if x < -limit:
        counters[place] += 1
        return -limit
    return x


@kernel("int64(int64)")
def leading_bit(x):
    """⌊log₂ x⌋ for x > 0; 0 for 0 and below."""
    found = np.int64(0)
    if x >= np.int64(1) << 32:
        x >>= 32
        found += 32
    if x >= 1 << 16:
        x >>= 16
        found += 16
    if x >= 1 << 8:
        x >>= 8
        found += 8
    if x >= 1 << 4:
        x >>= 4
        found += 4
    if x >= 1 << 2:
        x >>= 2
        found += 2
    if x >= 1 << 1:
        found += 1
    return found


@kernel
def shifted(x, bits):
    """x · 2^bits for −62 ≤ bits ≤ 62: to the left exactly, to the right with halves up."""
    if bits >= 0:
        return x << bits
    return rounded_shift(x, -bits)
