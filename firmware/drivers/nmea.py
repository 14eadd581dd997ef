"""Which NMEA sentence is this? Found by its address, whoever the talker is (fact sheet sections 1 to 3)."""

from typing import Final

import numpy as np

from firmware.drivers.message_fields import letters
from firmware.drivers.receiver_state import (
    FIELD,
    FIELD_COUNT,
    MESSAGE_ROW,
    MESSAGES,
    NONE,
    RING_MASK,
    TXT,
    UNKNOWN,
)
from firmware.numerics.dialect import kernel

PUBX_CODE: Final = int.from_bytes(b"PUBX", "big")


@kernel
def which_sentence(s, ring):
    """The message that the address field (and field 1 of a PUBX) names; NONE, and counted, when unknown.

    The sentence's checksum is proven and its commas are marked in the state.
    """
    mask = s[RING_MASK]
    begin = s[FIELD]
    length = s[FIELD + 1] - 1 - begin
    proprietary = length == 4 and letters(ring, mask, begin, begin + 4) == PUBX_CODE
    if proprietary and s[FIELD_COUNT] > 1 and s[FIELD + 2] - s[FIELD + 1] == 3:
        code = letters(ring, mask, s[FIELD + 1], s[FIELD + 1] + 2)
    elif length == 5:
        code = letters(ring, mask, begin + 2, begin + 5)
    else:
        code = np.int64(NONE)
    for message in range(np.int32(TXT + 1)):
        if s[MESSAGES + message * MESSAGE_ROW] == code:
            return np.int64(message)
    s[UNKNOWN] += 1
    return np.int64(NONE)
