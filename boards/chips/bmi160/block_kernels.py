"""The loop over a block of samples, compiled: values to register bytes.

It runs also interpreted (NUMBA_DISABLE_JIT=1) with the same results.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

STRIDE = 16
"""Bytes of a sample in a block: a zero, six of the gyroscope, six of the accelerometer, three of the time."""
DATA_END = 13
"""Where the data registers of a sample end and its sensor time begins."""


@njit(cache=True, error_model="numpy")
def fill_frames(
    values: NDArray[np.float64],
    scale: NDArray[np.float64],
    bias: NDArray[np.float64],
    first_tick: int,
    grid: int,
    frames: NDArray[np.uint8],
) -> None:
    """Counts of specific force and rate (n, ≥ 6) into frames (n, 16): saturated 16 bits, little endian, and
    the sensor time first_tick + i·grid."""
    for i in range(len(values)):
        tick = first_tick + i * grid
        frames[i, 0] = 0
        for byte in range(3):
            frames[i, 13 + byte] = (tick >> 8 * byte) & 0xFF
        for axis in range(6):
            counts = np.rint(values[i, axis] * scale[axis] + bias[axis])
            word = int(min(max(counts, -32768.0), 32767.0))
            at = 7 + 2 * axis if axis < 3 else 2 * axis - 5
            frames[i, at] = word & 0xFF
            frames[i, at + 1] = (word >> 8) & 0xFF
