"""Lengths of many CAN frames, compiled: `can_frame.frame_bits` for sets of eight-byte frames.

Runs also interpreted (NUMBA_DISABLE_JIT=1) with the same results.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, error_model="numpy")
def fill_lengths(
    heads: NDArray[np.int32],
    data: NDArray[np.uint8],
    crc_of_byte: NDArray[np.int32],
    stuffing: NDArray[np.int32],
    symbols: int,
    lengths: NDArray[np.int32],
) -> None:
    """lengths[n] of the frame with the bytes data[8 n] …; frame n has the head n modulo their number.

    heads: CRC, stuffing state and bits before the data; the tables as `can_frame` makes them, with `symbols`
    entries of `stuffing` for each state.
    """
    for n in range(len(lengths)):
        head = n % len(heads)
        crc = heads[head, 0]
        row = heads[head, 1] * symbols
        bits = heads[head, 2]
        for k in range(8):
            byte = data[8 * n + k]
            crc = (crc & 0x7F) << 8 ^ crc_of_byte[crc >> 7 ^ byte]
            step = stuffing[row + byte]
            row = step >> 2
            bits += step & 3
        step = stuffing[row + (crc >> 7)]
        tail = stuffing[(step >> 2) + 256 + (crc & 0x7F)]
        lengths[n] = bits + (step & 3) + (tail & 3)
