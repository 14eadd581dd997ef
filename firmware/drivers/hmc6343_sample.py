"""From the HMC6343's response to a heading command to radians: pure conversion in the kernel dialect.

Three words, high byte first: heading 0 … 3600, pitch and roll ±900 tenths of a degree; fact sheet section 3.
"""

import math
from typing import Final

import numpy as np

from firmware.drivers.signed_words import signed_16
from firmware.numerics.dialect import kernel

RESPONSE_LENGTH: Final = 6
RAD_PER_COUNT: Final = np.float32(math.pi / 1800.0)

HEADING: Final = 0
PITCH: Final = 1
ROLL: Final = 2
ANGLES_SIZE: Final = 3
"""A converted response, rad."""


@kernel("int64(uint8[::1], float32[::1])")
def convert(raw, angles):
    """Fill `angles` (ANGLES_SIZE) from a response. Returns 0."""
    angles[HEADING] = signed_16(raw[1], raw[0]) * RAD_PER_COUNT
    angles[PITCH] = signed_16(raw[3], raw[2]) * RAD_PER_COUNT
    angles[ROLL] = signed_16(raw[5], raw[4]) * RAD_PER_COUNT
    return np.int64(0)
