"""Scaling of a solution to the five CAN frames, in the kernel dialect: integers that saturate, little endian.

Which byte holds what stands in `can_output`.
"""

import math
from typing import Final

import numpy as np

from firmware.numerics.dialect import kernel

# Places in the float32 part of a solution record (firmware.nav.solution) and its length.
HEIGHT: Final = 0
VELOCITY: Final = 1
YAW: Final = 4
PITCH: Final = 5
ROLL: Final = 6
YAW_RATE: Final = 9
SIGMA_POSITION: Final = 10
SIGMA_VELOCITY: Final = 13
SIGMA_YAW: Final = 18
SOLUTION_FLOATS: Final = 19

HALF = np.float32(0.5)
ZERO = np.float32(0.0)
MILLI = np.float32(1000.0)
CENTI = np.float32(100.0)
TENTH = np.float32(10.0)
FIFTIETH = np.float32(50.0)
CENTIDEG = np.float32(18000.0 / math.pi)
DECIDEG = np.float32(1800.0 / math.pi)
LARGEST_MM = np.float32(2.0e9)
INT16_LARGEST = np.float32(32767.0)
UINT16_LARGEST = np.float32(65535.0)
UINT8_LARGEST = np.float32(255.0)
FULL_TURN = 36000
HUNDREDTH: Final = 42_949_673
"""⌊x/100⌋ = x·⌈2³²/100⌉ >> 32 for 0 ≤ x < 2³⁰."""


@kernel
def put(data, at, value, count):
    """`count` bytes of an integer, little endian."""
    rest = np.int64(value)
    for i in range(np.int32(count)):
        data[at + i] = np.uint8(rest & 0xFF)
        rest >>= 8


@kernel
def rounded(x, lowest, highest):
    """The integer nearest to x within limits that int32 can hold; not-a-number gives the highest."""
    limited = min(max(x, lowest), highest) if x == x else highest
    return np.int32(limited + HALF) if limited >= ZERO else -np.int32(HALF - limited)


@kernel
def signed_16(x):
    """Saturating."""
    return rounded(x, -INT16_LARGEST, INT16_LARGEST)


@kernel
def tenth_microdegrees(nanodeg):
    """Nearest 1e-7 degree: a division by 100 in two halves of at most 30 bits."""
    x = abs(nanodeg) + 50
    upper = ((x >> 16) * HUNDREDTH) >> 32
    rest = (((x >> 16) - upper * 100) << 16) | (x & 0xFFFF)
    value = (upper << 16) + ((rest * HUNDREDTH) >> 32)
    return -value if nanodeg < 0 else value


@kernel
def scale_motion(f, data, at):
    """Bytes 8 … 11 and 16 … 31 of the frames from `at` on: height, velocity, speed, angles, yaw rate."""
    put(data, at + 8, rounded(f[HEIGHT] * MILLI, -LARGEST_MM, LARGEST_MM), 4)
    for k in range(np.int32(3)):
        put(data, at + 16 + 2 * k, signed_16(f[VELOCITY + k] * CENTI), 2)
    north = f[VELOCITY]
    east = f[VELOCITY + 1]
    speed = np.float32(math.sqrt(north * north + east * east))
    put(data, at + 22, rounded(speed * CENTI, ZERO, UINT16_LARGEST), 2)
    yaw = rounded(f[YAW] * CENTIDEG, ZERO, UINT16_LARGEST)
    put(data, at + 24, 0 if yaw == FULL_TURN else yaw, 2)
    put(data, at + 26, signed_16(f[PITCH] * CENTIDEG), 2)
    put(data, at + 28, signed_16(f[ROLL] * CENTIDEG), 2)
    put(data, at + 30, signed_16(f[YAW_RATE] * CENTIDEG), 2)


@kernel
def scale_sigmas(f, data, at):
    """Bytes 35 … 39: sigmas of position, height, velocity and yaw."""
    north = f[SIGMA_POSITION]
    east = f[SIGMA_POSITION + 1]
    across = np.float32(math.sqrt(north * north + east * east))
    put(data, at + 35, rounded(across * CENTI, ZERO, UINT16_LARGEST), 2)
    put(data, at + 37, rounded(f[SIGMA_POSITION + 2] * TENTH, ZERO, UINT8_LARGEST), 1)
    north = f[SIGMA_VELOCITY]
    east = f[SIGMA_VELOCITY + 1]
    across = np.float32(math.sqrt(north * north + east * east))
    put(data, at + 38, rounded(across * FIFTIETH, ZERO, UINT8_LARGEST), 1)
    put(data, at + 39, rounded(f[SIGMA_YAW] * DECIDEG, ZERO, UINT8_LARGEST), 1)
