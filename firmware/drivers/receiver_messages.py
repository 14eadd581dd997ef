"""A message received in full, its checksum proven, is applied as a whole or not at all, and counted.

Empty fields are no error, fields missing at the end of a sentence read as empty.
"""

from typing import Final

import numpy as np

from firmware.drivers.epoch_update import update_epoch
from firmware.drivers.message_fields import read_fields
from firmware.drivers.receiver_state import (
    FIELD,
    FRAMES,
    GSA,
    GSV,
    LEAP,
    LEAP_READ,
    MALFORMED,
    MESSAGE,
    MESSAGE_ROW,
    MESSAGES,
    NAV_PVT,
    NAV_TIMEGPS,
    NOTICES,
    PUBX_04,
    RING_MASK,
    SENTENCES,
    STATUS,
    TXT,
    VALID_BITS,
)
from firmware.drivers.satellite_lists import satellites_in_view, satellites_used, series_is_good
from firmware.numerics.dialect import kernel

LEAP_MESSAGES: Final = 1 << PUBX_04 | 1 << NAV_TIMEGPS
FRAME_MESSAGES: Final = 1 << NAV_PVT | 1 << NAV_TIMEGPS
LEAP_IS_VALID: Final = 4
"""Bit 2 of NAV-TIMEGPS' valid flags."""


@kernel
def leap_seconds(s, message):
    """PUBX,04 and NAV-TIMEGPS: the leap seconds, when the receiver has got them from the satellites.

    PUBX,04 prints two digits; a third character (D) says that they are the firmware's default.
    """
    if message == NAV_TIMEGPS:
        if s[VALID_BITS] & LEAP_IS_VALID != 0:
            s[LEAP] = s[LEAP_READ]
        return
    tens = (s[STATUS] >> 8) - 48
    ones = (s[STATUS] & 0xFF) - 48
    if tens >= 0 and tens <= 9 and ones >= 0 and ones <= 9:
        s[LEAP] = tens * 10 + ones


@kernel
def apply_message(s, ring, epoch):
    """Apply the message at hand."""
    message = s[MESSAGE]
    row = MESSAGES + message * MESSAGE_ROW
    good = read_fields(s, ring, s[row + 1], s[row + 2]) and (message != GSV or series_is_good(s))
    if good and message == TXT:
        s[NOTICES] += 1
    elif good and (LEAP_MESSAGES >> message) & 1 == 1:
        leap_seconds(s, message)
    elif good:
        good = update_epoch(s, epoch, message)
    talker = np.int64(ring[(s[FIELD] + 1) & s[RING_MASK]])
    if good and message == GSV:
        satellites_in_view(s, talker)
    elif good and message == GSA:
        satellites_used(s, talker)
    received = FRAMES if (FRAME_MESSAGES >> message) & 1 == 1 else SENTENCES
    s[received if good else MALFORMED] += 1
