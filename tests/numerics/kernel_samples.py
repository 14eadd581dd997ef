"""Kernels for the tests of the decorator itself."""

import math

import numpy as np

from firmware.numerics.dialect import kernel

TWO = np.float32(2.0)


@kernel("float32(float32, float32)")
def hypotenuse(x, y):
    return np.float32(math.sqrt(x * x + y * y))


@kernel
def doubled(x):
    return x * TWO


@kernel("void(float32[::1], int64[::1], int64, float32)")
def entry(f, i, n, scale):
    f[0] = hypotenuse(doubled(f[0]), scale)
    f[1] = f[0] / (f[1] - f[1])
    i[0] += n


@kernel("UniTuple(float32, 2)(float32)")
def overflows(x):
    return x * x * x, x - x
