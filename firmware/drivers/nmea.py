"""Which NMEA sentence is this? Found by its address, whoever the talker is (fact sheet sections 1 to 3, 6).

Proprietary addresses begin with P and the maker; PUBX, PSAT and PTNL say in field 1 what they are, so may
PASHR.
"""

from typing import Final

import numpy as np

from firmware.drivers.message_fields import letters
from firmware.drivers.receiver_state import (
    FIELD,
    FIELD_COUNT,
    MESSAGE_COUNT,
    MESSAGE_ROW,
    MESSAGES,
    NONE,
    RING_MASK,
    UNKNOWN,
)
from firmware.numerics.dialect import kernel

PUBX_CODE: Final = int.from_bytes(b"PUBX", "big")
PSAT_CODE: Final = int.from_bytes(b"PSAT", "big")
PTNL_CODE: Final = int.from_bytes(b"PTNL", "big")
PASHR_CODE: Final = int.from_bytes(b"SHR", "big")
HPR_CODE: Final = int.from_bytes(b"HPR", "big")
AVR_CODE: Final = int.from_bytes(b"AVR", "big")
PSAT_HPR_CODE: Final = int.from_bytes(b"THPR", "big")
"""Codes of this table; a PSAT and a PASHR of the same kind are not the same sentence."""
PASHR_HPR_CODE: Final = int.from_bytes(b"RHPR", "big")
PTNL_AVR_CODE: Final = int.from_bytes(b"LAVR", "big")


@kernel
def sort_of(s, ring, code):
    """Field 1 of a proprietary sentence as a number, when it is one of three letters; else `code`."""
    begin = s[FIELD + 1]
    if s[FIELD_COUNT] < 2 or s[FIELD + 2] - 1 - begin != 3:
        return code
    return letters(ring, s[RING_MASK], begin, begin + 3)


@kernel
def which_sentence(s, ring):
    """The message that the address field (and field 1 of a PUBX) names; NONE, and counted, when unknown.

    The sentence's checksum is proven and its commas are marked in the state.
    """
    mask = s[RING_MASK]
    begin = s[FIELD]
    length = s[FIELD + 1] - 1 - begin
    maker = letters(ring, mask, begin, begin + 4) if length == 4 else np.int64(0)
    if maker == PUBX_CODE and s[FIELD_COUNT] > 1 and s[FIELD + 2] - s[FIELD + 1] == 3:
        code = letters(ring, mask, s[FIELD + 1], s[FIELD + 1] + 2)
    elif maker == PSAT_CODE and sort_of(s, ring, np.int64(0)) == HPR_CODE:
        code = np.int64(PSAT_HPR_CODE)
    elif maker == PTNL_CODE and sort_of(s, ring, np.int64(0)) == AVR_CODE:
        code = np.int64(PTNL_AVR_CODE)
    elif length == 5:
        code = letters(ring, mask, begin + 2, begin + 5)
        if code == PASHR_CODE and sort_of(s, ring, code) == HPR_CODE:
            code = np.int64(PASHR_HPR_CODE)
    else:
        code = np.int64(NONE)
    for message in range(np.int32(MESSAGE_COUNT)):
        if s[MESSAGES + message * MESSAGE_ROW] == code:
            return np.int64(message)
    s[UNKNOWN] += 1
    return np.int64(NONE)
