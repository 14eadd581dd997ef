"""CRC-16/CCITT-FALSE: polynomial x¹⁶ + x¹² + x⁵ + 1 (0x1021), start 0xFFFF, not reflected, not inverted.

A byte at a time without a table. With t the upper byte of the remainder ⊕ the data byte, and
x = t ⊕ (t ≫ 4), the eight divisions come to

    crc ← (crc ≪ 8) ⊕ (x ≪ 12) ⊕ (x ≪ 5) ⊕ x
"""

import numpy as np

from firmware.numerics.dialect import kernel


@kernel("int32(uint8[::1], int32, int32)")
def crc16(data, begin, end):
    """CRC of data[begin:end]."""
    crc = np.int32(0xFFFF)
    for i in range(np.int32(end - begin)):
        x = (crc >> 8) ^ np.int64(data[begin + i])
        x ^= x >> 4
        crc = np.int32(((crc << 8) ^ (x << 12) ^ (x << 5) ^ x) & 0xFFFF)
    return crc


@kernel("void(uint8[::1], int32, int32)")
def append_crc(data, begin, end):
    """Write the CRC of data[begin:end] behind it, low byte first."""
    crc = crc16(data, begin, end)
    data[end] = np.uint8(crc & 0xFF)
    data[end + 1] = np.uint8(crc >> 8)
