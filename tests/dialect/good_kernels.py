"""Kernels that use all the dialect allows; neither the source rules nor the gate may object to any.

Not imported: the gate's own tests run this file with a decorator of theirs in place of `kernel`.
"""

import math

import numpy as np

from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
SIZE = np.int32(8)
COLUMNS = 4
LARGEST = np.int64(2**31 - 1)
PAIR = (np.float32(1.5), np.float32(2.5))


@kernel("float32(float32)")
def wrapped_root(x):
    """np.float32 around math at once; ternary."""
    return np.float32(math.sqrt(x)) * HALF if x >= ZERO else ZERO


@kernel("void(float32[::1], int32)")
def loops_over_a_flat_array(p, offset):
    """int32 counters, index constants, an inner kernel, an offset."""
    for i in range(SIZE):
        for j in range(np.int32(COLUMNS)):
            if i != j and not math.isnan(p[i * COLUMNS + j]):
                p[i * COLUMNS + j] = halved(p[j]) + p[(offset & 7) + i]


@kernel
def halved(x):
    return x * HALF


@kernel("int32(int32, int32)")
def fixed_point(a, b):
    """Widened product, shifted, saturated, narrowed."""
    product = (np.int64(a) * np.int64(b)) >> 30
    return np.int32(min(max(product, -LARGEST), LARGEST))


@kernel("Tuple((float32, int64))(float32)")
def tuple_and_while(x):
    n = np.int64(0)
    while n < 3:
        n += 1
        x = x * PAIR[0]
    return x, n


@kernel("int32(float32)")
def bits_of(x):
    return np.float32(x).view(np.int32)


@kernel("float32(float32, float32)")
def may_give_nan(x, y):
    return x / y - np.float32(math.copysign(min(x, y), max(x, abs(y))))


@kernel("int64(int64)")
def divided_by_constants(x):
    return x // 8 + x % 16


@kernel("int32(float32)")
def clamped_cast(x):
    if x != x:
        return np.int32(0)
    return np.int32(min(max(x, -HALF), HALF))


@kernel("boolean(uint8[::1], int64)")
def letter(p, n):
    return p[n & 7] == ord("A")


@kernel("int64(int32[::1], int64)")
def in_fixed_point_scaled(p, scale):
    """Integers only: a 64-bit product, rounded, saturated."""
    x = (np.int64(p[0]) * (scale & 0xFFFF) + (np.int64(1) << 15)) >> 16
    x = min(max(x, -LARGEST), LARGEST)
    p[1] = np.int32(x)
    return x
