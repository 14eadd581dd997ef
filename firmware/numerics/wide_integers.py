"""Between float32 and int64 without a library call.

A Cortex-M4F converts float32 to and from int32 in one instruction; for int64 the compiler would call its
run-time library. Two int32 halves do the same, exactly rounded.
"""

import numpy as np

from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
TWO_24 = np.float32(2.0**24)
TWO_M24 = np.float32(2.0**-24)
LOW_24_BITS = np.int64(0xFFFFFF)
LARGEST_ROUNDED = np.float32(2.0**53)


@kernel("float32(int64)")
def float32_of_int64(value):
    """The float32 nearest to `value`, |value| < 2⁴⁸ (as nanoseconds: 3 days; as 2⁻⁴⁰ rad: 256 rad)."""
    high = np.float32(np.int32(value >> 24))
    low = np.float32(np.int32(value & LOW_24_BITS))
    return high * TWO_24 + low


@kernel("int64(float32)")
def int64_of_float32(x):
    """The integer nearest to x, halves away from zero; ±2⁵³ at most, 0 for NaN."""
    if x != x:
        return np.int64(0)
    x = min(max(x, -LARGEST_ROUNDED), LARGEST_ROUNDED)
    high = np.int32(x * TWO_M24)
    rest = x - np.float32(high) * TWO_24
    low = np.int32(rest)
    fraction = rest - np.float32(low)
    step = np.int64(0)
    if fraction >= HALF:
        step = np.int64(1)
    elif fraction <= -HALF:
        step = np.int64(-1)
    return (np.int64(high) << 24) + np.int64(low) + step
