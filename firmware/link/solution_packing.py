"""A solution as bytes for both ports, in the kernel dialect: the SOLUTION frame, sealed, and five CAN frames.

One buffer holds both. The frame begins two bytes into it, so that the 19 numbers at the end of its payload
lie on multiples of four, where `numbers`, the same memory as float32, reaches them.

      0  2 bytes left free
      2  A5 5A, type, length, sequence (`frames`)
      7  time u64, time of day u32, date u16, mode u8, flags u16, latitude i64, longitude i64
     40  19 × float32: the floats of a solution record (`firmware.nav.solution`), in its order
    116  CRC
    120  5 × 8 bytes of CAN (`can_output`)
"""

from typing import Final

import numpy as np

from firmware.link.can_scaling import (
    SOLUTION_FLOATS,
    put,
    scale_motion,
    scale_sigmas,
    tenth_microdegrees,
)
from firmware.link.crc import append_crc
from firmware.numerics.dialect import kernel

FRAME_AT: Final = 2
SEALED_AT: Final = 4
SEQUENCE_AT: Final = 6
PAYLOAD_AT: Final = 7
NUMBERS_AT: Final = 10
"""In float32."""
CRC_AT: Final = 116
FRAME_END: Final = 118
CAN_AT: Final = 120
SIZE: Final = 160

# Places in the integers of a solution record.
LAT_NANODEG: Final = 1
LON_NANODEG: Final = 2
MODE: Final = 3
FLAGS: Final = 4

# Places in the words that come with it.
TIME_US: Final = 0
TIME_OF_DAY_MS: Final = 1
DATE_DAYS: Final = 2
SEQUENCE: Final = 3
COUNTER: Final = 4
WORDS: Final = 5


@kernel("void(float32[::1], int64[::1], int64[::1], uint8[::1], float32[::1])")
def pack_solution(floats, integers, words, data, numbers):
    """Write everything but sync, type and length, which stay. `floats`, `integers`: a solution record."""
    data[SEQUENCE_AT] = np.uint8(words[SEQUENCE] & 0xFF)
    put(data, PAYLOAD_AT, words[TIME_US], 8)
    put(data, PAYLOAD_AT + 8, words[TIME_OF_DAY_MS], 4)
    put(data, PAYLOAD_AT + 12, words[DATE_DAYS], 2)
    put(data, PAYLOAD_AT + 14, integers[MODE], 1)
    put(data, PAYLOAD_AT + 15, integers[FLAGS], 2)
    put(data, PAYLOAD_AT + 17, integers[LAT_NANODEG], 8)
    put(data, PAYLOAD_AT + 25, integers[LON_NANODEG], 8)
    for k in range(np.int32(SOLUTION_FLOATS)):
        numbers[NUMBERS_AT + k] = floats[k]
    append_crc(data, np.int32(SEALED_AT), np.int32(CRC_AT))
    put(data, CAN_AT, tenth_microdegrees(integers[LAT_NANODEG]), 4)
    put(data, CAN_AT + 4, tenth_microdegrees(integers[LON_NANODEG]), 4)
    put(data, CAN_AT + 12, words[TIME_OF_DAY_MS], 4)
    put(data, CAN_AT + 32, integers[MODE] & 15 | (words[COUNTER] & 15) << 4, 1)
    put(data, CAN_AT + 33, integers[FLAGS], 2)
    scale_motion(floats, data, CAN_AT)
    scale_sigmas(floats, data, CAN_AT)
