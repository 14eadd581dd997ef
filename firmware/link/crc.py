"""CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, no reflection, no final exclusive-or."""

import numpy as np

from firmware.numerics.dialect import kernel

START = np.int32(0xFFFF)
POLYNOMIAL = np.int32(0x1021)
TOP_BIT = np.int32(0x8000)
MASK = np.int32(0xFFFF)
EIGHT = np.int32(8)


@kernel("int32(uint8[::1], int32, int32)")
def crc16(data, begin, end):
    """CRC of data[begin:end]."""
    crc = START
    for k in range(begin, end):
        crc = crc ^ np.int32(np.int64(data[k]) << np.int64(8))
        for _ in range(EIGHT):
            shifted = np.int32((np.int64(crc) << np.int64(1)) & np.int64(MASK))
            crc = shifted ^ POLYNOMIAL if (crc & TOP_BIT) != np.int32(0) else shifted
    return crc
