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

from struct import Struct
from typing import Final

SYNC: Final = b"\xaa\x55"
LENGTH: Final = 32
COUNTER_MASK: Final = 0xFFFF
ANGLE_LSB: Final = 1e-9
VELOCITY_LSB: Final = 1e-8

GYRO_RANGE, ACCEL_RANGE, STARTING, SELF_TEST_FAILED = 0x0001, 0x0002, 0x0004, 0x0008
"""Status: a gyro or an accelerometer was beyond its range; not warm yet; the self-test has failed."""

_BODY = Struct("<H6iH")
_POLYNOMIAL: Final = 0x1021


def _table() -> list[int]:
    table = []
    for value in range(256):
        remainder = value << 8
        for _ in range(8):
            remainder = (remainder << 1 ^ _POLYNOMIAL if remainder & 0x8000 else remainder << 1) & 0xFFFF
        table.append(remainder)
    return table


_REMAINDERS = _table()


def check_of(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, not reflected."""
    crc = 0xFFFF
    for value in data:
        crc = (crc << 8 ^ _REMAINDERS[crc >> 8 ^ value]) & 0xFFFF
    return crc


def frame(counter: int, counts: list[int], status: int) -> bytes:
    """One frame of six increments in their units, each within 32 bits."""
    body = _BODY.pack(counter & COUNTER_MASK, *counts, status)
    return SYNC + body + check_of(body).to_bytes(2, "little")
