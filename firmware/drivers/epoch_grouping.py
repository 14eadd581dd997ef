"""Which messages belong to one navigation epoch, and when is it complete.

A receiver prints an epoch as several messages; only some of them carry the time of day. An epoch is
complete, and given out once, at the first of
  1. a message with another time of day, or a position message without a time whose kind was already met,
  2. the message that the owner named as the last one (LAST_MESSAGE),
  3. a silence on the line longer than GAP_NS.
Messages without a time belong to the epoch that is open. What still comes for an epoch already given out
is dropped, so that no epoch is given twice.

Times of day that differ by SAME_EPOCH_MS or less are one epoch: NMEA prints hundredths of a second where
UBX gives nanoseconds. Receivers of this class do not navigate faster than 50 Hz.
"""

from typing import Final

import numpy as np

from firmware.drivers.gnss_epoch import (
    BURST_END_NS,
    BURST_START_NS,
    FIX_TYPE,
    FLAGS,
    HAS_ATTITUDE_ACCURACY,
    HAS_BASELINE,
    HAS_DATE,
    HAS_HEADING,
    HAS_HEIGHT,
    HAS_HEIGHT_MSL,
    HAS_PITCH,
    HAS_ROLL,
    HAS_TIME,
    HAS_VELOCITY,
    LEAP_SECONDS,
    RECORD_SIZE,
    TIME_OF_DAY_MS,
)
from firmware.drivers.receiver_state import (
    BURST_NS,
    CLOSED,
    COLLECTING,
    DELIVERED,
    END_NS,
    EPOCHS,
    GGA,
    GIVEN,
    GLL,
    GNS,
    LAST_MESSAGE,
    LEAP,
    NAV_PVT,
    PHASE,
    PUBX_00,
    RANK,
    READY,
    REFUSED,
    RMC,
    SEEN,
    START_NS,
    WORK,
)
from firmware.numerics.dialect import kernel

SAME_EPOCH_MS: Final = 10
NO_TIME: Final = -1
DAY_MS: Final = 86_400_000
POSITION_MESSAGES: Final = 1 << GGA | 1 << RMC | 1 << GLL | 1 << GNS | 1 << PUBX_00 | 1 << NAV_PVT
ATTITUDE: Final = HAS_HEADING | HAS_PITCH | HAS_ROLL | HAS_ATTITUDE_ACCURACY | HAS_BASELINE
WITHOUT_FIX: Final = HAS_TIME | HAS_DATE | ATTITUDE
"""What is left of an epoch when one of its messages said that the fix is not valid."""

VERTICAL: Final = HAS_HEIGHT | HAS_HEIGHT_MSL | HAS_VELOCITY
"""What a two-dimensional fix does not measure."""
TWO_DIMENSIONAL: Final = 2


@kernel
def another_time(a, b):
    """Whether two times of day belong to different epochs; midnight between them does no harm."""
    apart = abs(a - b)
    return apart > SAME_EPOCH_MS and apart < DAY_MS - SAME_EPOCH_MS


@kernel
def give_out(s, epoch):
    """Copy the epoch being filled into `epoch` and say that it is ready."""
    s[WORK + LEAP_SECONDS] = s[LEAP]
    if s[REFUSED] != 0:
        s[WORK + FLAGS] &= WITHOUT_FIX
    if s[WORK + FIX_TYPE] == TWO_DIMENSIONAL:
        s[WORK + FLAGS] &= ~VERTICAL
    for i in range(np.int32(RECORD_SIZE)):
        epoch[i] = s[WORK + i]
    s[PHASE] = GIVEN
    s[READY] = 1
    s[DELIVERED] += 1


@kernel
def open_epoch(s):
    """Start an empty epoch with the message at hand."""
    for i in range(np.int32(RECORD_SIZE)):
        s[WORK + i] = 0
        s[RANK + i] = 0
    s[SEEN] = 0
    s[REFUSED] = 0
    s[PHASE] = COLLECTING
    s[EPOCHS] += 1
    s[WORK + BURST_START_NS] = s[BURST_NS] if s[BURST_NS] >= 0 else s[START_NS]
    s[BURST_NS] = -1


@kernel
def enter(s, epoch, message, time_ms):
    """Find the epoch of the message at hand (`time_ms` NO_TIME: it carries none) and mark it as met there.

    False when that epoch has been given out already: the message must not be applied.
    """
    timed = s[PHASE] != CLOSED and (s[WORK + FLAGS] & HAS_TIME) != 0
    repeated = (s[SEEN] & POSITION_MESSAGES & (np.int64(1) << message)) != 0
    if time_ms >= 0:
        begins = timed and another_time(time_ms, s[WORK + TIME_OF_DAY_MS])
        # a time that comes to an epoch given out without one says nothing about which epoch it is
        begins = begins or (s[PHASE] == GIVEN and not timed)
    else:
        begins = repeated
    if s[PHASE] == COLLECTING and begins:
        give_out(s, epoch)
    if s[PHASE] == CLOSED or begins:
        open_epoch(s)
    elif s[PHASE] == GIVEN:
        return False
    s[SEEN] |= np.int64(1) << message
    s[WORK + BURST_END_NS] = s[END_NS]
    if time_ms >= 0 and (s[WORK + FLAGS] & HAS_TIME) == 0:
        s[WORK + FLAGS] |= HAS_TIME
        s[WORK + TIME_OF_DAY_MS] = time_ms
    return True


@kernel
def leave(s, epoch, message):
    """After the message has been applied: give the epoch out when it was the last one expected."""
    if s[LAST_MESSAGE] == message and s[PHASE] == COLLECTING:
        give_out(s, epoch)


@kernel
def silence(s, epoch):
    """The line fell silent: the burst is over."""
    if s[PHASE] == COLLECTING:
        give_out(s, epoch)
    s[PHASE] = CLOSED
