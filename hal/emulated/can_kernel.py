"""Ends of many CAN frames, compiled: what `can_frame.frame_bits` says, for sets of eight-byte frames.

Runs also interpreted (NUMBA_DISABLE_JIT=1) with the same results.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

SECOND = 1_000_000_000


@njit(cache=True, error_model="numpy")
def fill_ends(
    begins_ns: NDArray[np.int64],
    heads: NDArray[np.int32],
    data: NDArray[np.uint8],
    crc_of_byte: NDArray[np.int32],
    stuffing: NDArray[np.int32],
    gap_bits: int,
    bitrate: int,
    ends_ns: NDArray[np.int64],
) -> int:
    """When each frame ends; sets begin at `begins_ns`, with `gap_bits` behind every frame. Returns all bits.

    heads: of each frame of a set CRC, stuffing state and bits before its data. crc_of_byte, stuffing: the
    tables of `can_frame`, of stuffing an eighth for each state.
    """
    symbols = len(stuffing) // 8
    together = 0
    for n in range(len(ends_ns)):
        which = n % len(heads)
        if which == 0:
            bits = 0
        crc = int(heads[which, 0])
        row = int(heads[which, 1]) * symbols
        bits += int(heads[which, 2])
        for k in range(8):
            byte = int(data[8 * n + k])
            crc = (crc & 0x7F) << 8 ^ int(crc_of_byte[crc >> 7 ^ byte])
            step = int(stuffing[row + byte])
            row = step >> 2
            bits += step & 3
        step = int(stuffing[row + (crc >> 7)])
        tail = int(stuffing[(step >> 2) + 256 + (crc & 0x7F)])
        bits += (step & 3) + (tail & 3)
        ends_ns[n] = int(begins_ns[n // len(heads)]) + bits * SECOND // bitrate
        bits += gap_bits
        if which == len(heads) - 1:
            together += bits
    return together
