"""The frame: 32 bytes, all numbers little endian.

| offset | field | unit |
| --- | --- | --- |
| 0 | sync AA 55 | |
| 2 | counter, 16 bits, one a sample | |
| 4 | angle increments x, y, z, 3 × int32 | 10⁻⁹ rad |
| 16 | velocity increments x, y, z, 3 × int32 | 10⁻⁸ m/s |
| 28 | status, 16 bits | |
| 30 | CRC-16/CCITT-FALSE over bytes 2 … 29 | |

An increment is the integral of rate or specific force over the time since the sample before.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

SYNC: Final = b"\xaa\x55"
LENGTH: Final = 32
COUNTER_MASK: Final = 0xFFFF
ANGLE_LSB: Final = 1e-9
VELOCITY_LSB: Final = 1e-8

GYRO_RANGE, ACCEL_RANGE, STARTING, SELF_TEST_FAILED = 0x0001, 0x0002, 0x0004, 0x0008
"""Status: a gyro or an accelerometer was beyond its range; not warm yet; the self-test has failed."""

_FRAME = np.dtype(
    [("sync", "u1", 2), ("counter", "<u2"), ("counts", "<i4", 6), ("status", "<u2"), ("check", "<u2")]
)
_POLYNOMIAL: Final = 0x1021


def _table() -> NDArray[np.int64]:
    table = []
    for value in range(256):
        remainder = value << 8
        for _ in range(8):
            remainder = (remainder << 1 ^ _POLYNOMIAL if remainder & 0x8000 else remainder << 1) & 0xFFFF
        table.append(remainder)
    return np.array(table, np.int64)


_REMAINDERS = _table()


@njit(cache=True, error_model="numpy")
def seal(rows: NDArray[np.uint8]) -> None:
    """Write the check of each row of (n, LENGTH), low byte first: polynomial 0x1021, start 0xFFFF, not
    reflected."""
    for row in range(rows.shape[0]):
        crc = 0xFFFF
        for at in range(2, LENGTH - 2):
            crc = (crc << 8 & 0xFFFF) ^ _REMAINDERS[crc >> 8 ^ rows[row, at]]
        rows[row, LENGTH - 2] = crc & 0xFF
        rows[row, LENGTH - 1] = crc >> 8


def frames(first: int, counts: NDArray[np.int64], status: NDArray[np.int64]) -> list[bytes]:
    """Frames numbered from `first` on; `counts` (n, 6): increments in their units, each within 32 bits."""
    table = np.zeros(len(counts), _FRAME)
    table["sync"] = np.frombuffer(SYNC, np.uint8)
    table["counter"] = (first + np.arange(len(counts))) & COUNTER_MASK
    table["counts"] = counts
    table["status"] = status
    seal(table.view(np.uint8).reshape(-1, LENGTH))
    whole = table.tobytes()
    return [whole[begin : begin + LENGTH] for begin in range(0, len(whole), LENGTH)]
