"""The checksum of an NMEA sentence: XOR of all characters between `$` and `*`."""

import numpy as np

from firmware.numerics.dialect import kernel


@kernel("int32(uint8[::1], int32)")
def exclusive_or(data, count):
    """XOR of the first `count` bytes."""
    check = np.int32(0)
    for i in range(count):
        check = np.int32(check ^ np.int32(data[i]))
    return check
