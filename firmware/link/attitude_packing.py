"""A solution in integers as an ATTITUDE frame, in the kernel dialect: no division, no float.

      0  A5 5A, type, length, sequence (`frames`)
      5  time u64, mode u8, flags u16, age of the sample u16
     18  latitude, longitude, height i64
     42  12 × i32: velocity north, east, down in 1e-6 m/s; yaw, pitch, roll in 4e-9 rad; rates x, y, z and
         gyro biases x, y, z in 4e-9 rad/s; values that do not fit saturate
     90  CRC

The record holds 1e-9 rad; a quarter of it (rounded, halves upwards) fits a full turn and ±490 °/s into 32
bits.
"""

from typing import Final

import numpy as np

from firmware.link.can_scaling import put
from firmware.link.crc import append_crc
from firmware.nav.attitude.layout import (
    OUT_GYRO_BIAS,
    OUT_HEIGHT,
    OUT_LATITUDE,
    OUT_LONGITUDE,
    OUT_RATE,
    OUT_VELOCITY,
    OUT_YAW,
)
from firmware.numerics.dialect import kernel

SEALED_AT: Final = 2
SEQUENCE_AT: Final = 4
PAYLOAD_AT: Final = 5
NUMBERS_AT: Final = 42
CRC_AT: Final = 90
FRAME_BYTES: Final = 92

# Places in the words that come with a record.
TIME_US: Final = 0
MODE: Final = 1
FLAGS: Final = 2
AGE_US: Final = 3
SEQUENCE: Final = 4
WORDS: Final = 5

LARGEST = np.int64(0x7FFF_FFFF)


@kernel
def saturated(value):
    """To 32 bits."""
    return min(max(value, -LARGEST - np.int64(1)), LARGEST)


@kernel
def quarter(value):
    """The nearest integer to value / 4, halves upwards, in 32 bits."""
    return saturated((value + np.int64(2)) >> np.int64(2))


@kernel("void(int64[::1], int64[::1], uint8[::1])")
def pack_attitude(record, words, data):
    """Write everything but sync, type and length, which stay."""
    data[SEQUENCE_AT] = np.uint8(words[SEQUENCE] & 0xFF)
    put(data, PAYLOAD_AT, words[TIME_US], 8)
    put(data, PAYLOAD_AT + 8, words[MODE], 1)
    put(data, PAYLOAD_AT + 9, words[FLAGS], 2)
    put(data, PAYLOAD_AT + 11, words[AGE_US], 2)
    put(data, PAYLOAD_AT + 13, record[OUT_LATITUDE], 8)
    put(data, PAYLOAD_AT + 21, record[OUT_LONGITUDE], 8)
    put(data, PAYLOAD_AT + 29, record[OUT_HEIGHT], 8)
    for k in range(np.int32(3)):
        put(data, NUMBERS_AT + 4 * k, saturated(record[OUT_VELOCITY + k]), 4)
        put(data, NUMBERS_AT + 12 + 4 * k, quarter(record[OUT_YAW + k]), 4)
        put(data, NUMBERS_AT + 24 + 4 * k, quarter(record[OUT_RATE + k]), 4)
        put(data, NUMBERS_AT + 36 + 4 * k, quarter(record[OUT_GYRO_BIAS + k]), 4)
    append_crc(data, np.int32(SEALED_AT), np.int32(CRC_AT))
