"""State of one receiver's byte stream: index constants into a flat int64 array, shared by the kernels
that take the stream apart (`receiver_demux`), read fields (`message_fields`) and group epochs.

Positions are counts of bytes since reception started, never wrapped; position & RING_MASK is the index
into the DMA ring. Times are nanoseconds of the board's clock. The last part of the array is constant: the
table of message layouts that `message_table` writes at set-up.
"""

from typing import Final

from firmware.drivers.gnss_epoch import RECORD_SIZE

# What the message at hand says. The first RECORD_SIZE slots are those of the epoch record.
YEAR: Final = RECORD_SIZE
MONTH: Final = RECORD_SIZE + 1
DAY: Final = RECORD_SIZE + 2
SEPARATION: Final = RECORD_SIZE + 3
"""Geoid above the ellipsoid, mm."""
STATUS: Final = RECORD_SIZE + 4
"""Letters of a status field, the last one in the lowest byte."""
MODE_QUALITY: Final = RECORD_SIZE + 5
"""Fix quality that the mode letters stand for."""
NORTH_SIGMA: Final = RECORD_SIZE + 6
EAST_SIGMA: Final = RECORD_SIZE + 7
VALID_BITS: Final = RECORD_SIZE + 8
FIX_BITS: Final = RECORD_SIZE + 9
NANO: Final = RECORD_SIZE + 10
HOUR: Final = RECORD_SIZE + 11
MINUTE: Final = RECORD_SIZE + 12
SECOND: Final = RECORD_SIZE + 13
COURSE_SIGMA: Final = RECORD_SIZE + 14
LEAP_READ: Final = RECORD_SIZE + 15
SERIES_LENGTH: Final = RECORD_SIZE + 16
"""GSV: sentences in this series, and the number of this one."""
SERIES_NUMBER: Final = RECORD_SIZE + 17
LIST: Final = RECORD_SIZE + 18
"""Numbers of a satellite list, as many as a GSV has behind its third comma."""
LIST_LENGTH: Final = 16
ATTITUDE_QUALITY: Final = LIST + LIST_LENGTH
"""The figure by which an attitude sentence says how good it is; each has its own meaning."""
SLOTS: Final = LIST + LIST_LENGTH + 1
GOT: Final = SLOTS
"""One for each slot: 1 when the message at hand gave it."""
RANK: Final = GOT + SLOTS
"""Of each epoch field: how fine the message was that gave it."""

_OWN: Final = RANK + RECORD_SIZE

# Set by the owner of the stream.
RING_MASK: Final = _OWN + 0
"""Length of the ring − 1; the length is a power of two."""
BYTE_NS: Final = _OWN + 1
"""Ten bits at the present baud rate."""
GAP_NS: Final = _OWN + 2
"""A silence longer than this ends a burst, and with it the epoch."""
LAST_MESSAGE: Final = _OWN + 3
"""The message that completes an epoch at once, or −1."""
LONGEST_FRAME: Final = _OWN + 4
"""Longest UBX frame to wait for, bytes."""

# The demultiplexer.
MODE: Final = _OWN + 5
START: Final = _OWN + 6
"""Position of the first byte of the sentence or frame at hand."""
CHECK: Final = _OWN + 7
CHUNK_END: Final = _OWN + 8
CHUNK_NS: Final = _OWN + 9
"""Time at the end of the last byte before CHUNK_END."""
TAKEN: Final = _OWN + 10
"""End of all bytes taken in so far; their last one ended at LAST_BYTE_NS."""
LAST_BYTE_NS: Final = _OWN + 11
START_NS: Final = _OWN + 12
"""Time at the first bit of the message at hand."""
END_NS: Final = _OWN + 13
"""Time at the last bit of the message at hand."""
READY: Final = _OWN + 14
"""1 when the epoch record given to the demultiplexer has just been filled."""

# The epoch at hand.
PHASE: Final = _OWN + 15
SEEN: Final = _OWN + 16
"""Messages met in this epoch, one bit each."""
REFUSED: Final = _OWN + 17
"""1 when a message of this epoch said that the fix is not valid."""
BURST_NS: Final = _OWN + 18
"""Time of the first bit of the burst; −1 once an epoch has taken it."""
EPOCHS: Final = _OWN + 19
"""Epochs opened so far; also the stamp of the satellite lists."""
LEAP: Final = _OWN + 20

# What was heard.
SENTENCES: Final = _OWN + 21
FRAMES: Final = _OWN + 22
BAD_CHECKSUMS: Final = _OWN + 23
OVERLONG: Final = _OWN + 24
TRUNCATED: Final = _OWN + 25
UNKNOWN: Final = _OWN + 26
MALFORMED: Final = _OWN + 27
GARBAGE: Final = _OWN + 28
OVERRUNS: Final = _OWN + 29
NOTICES: Final = _OWN + 30
"""TXT sentences."""
ACKS: Final = _OWN + 31
ACK_OF: Final = _OWN + 32
"""class << 8 | id of the message acknowledged last."""
NAKS: Final = _OWN + 33
NAK_OF: Final = _OWN + 34
VERSIONS: Final = _OWN + 35
"""MON-VER frames."""
DELIVERED: Final = _OWN + 36
"""Epochs given out."""
MESSAGE: Final = _OWN + 37
"""The message just received in full, or NONE."""

# Fields of the sentence at hand: position after each comma.
FIELD_COUNT: Final = _OWN + 38
FIELD: Final = _OWN + 39
FIELD_LIMIT: Final = 32

# Satellites used (packed system << 16 | number) and in view (rows).
USED_COUNT: Final = FIELD + FIELD_LIMIT + 1
USED_STAMP: Final = USED_COUNT + 1
USED: Final = USED_STAMP + 1
USED_LIMIT: Final = 48
VIEW_COUNT: Final = USED + USED_LIMIT
VIEW: Final = VIEW_COUNT + 1
VIEW_LIMIT: Final = 64
VIEW_ROW: Final = 5
"""packed system and number, elevation °, azimuth °, C/N0 dBHz, stamp; −1 is an empty field."""

WORK: Final = VIEW + VIEW_LIMIT * VIEW_ROW
"""The epoch record being filled."""
FLAG_OF: Final = WORK + RECORD_SIZE
"""The flag that each field of the record sets."""
MESSAGES: Final = FLAG_OF + RECORD_SIZE
"""For each message: code, first layout row, end of layout rows, rank."""
MESSAGE_ROW: Final = 4
MESSAGE_COUNT: Final = 21
LAYOUT: Final = MESSAGES + MESSAGE_COUNT * MESSAGE_ROW
LAYOUT_ROW: Final = 7
LAYOUT_LIMIT: Final = 192
STATE_SIZE: Final = LAYOUT + LAYOUT_LIMIT * LAYOUT_ROW

# Values of MODE.
HUNTING: Final = 0
SENTENCE: Final = 1
FIRST_DIGIT: Final = 2
SECOND_DIGIT: Final = 3
FRAME: Final = 4

# Values of PHASE.
CLOSED: Final = 0
COLLECTING: Final = 1
GIVEN: Final = 2
"""Delivered; what still comes for the same epoch is dropped."""

# Messages: row in the table, bit number of SEEN, value of LAST_MESSAGE.
GGA: Final = 0
RMC: Final = 1
GSA: Final = 2
GSV: Final = 3
GLL: Final = 4
VTG: Final = 5
ZDA: Final = 6
GNS: Final = 7
GST: Final = 8
PUBX_00: Final = 9
HDT: Final = 10
THS: Final = 11
NAV_PVT: Final = 12
PUBX_04: Final = 13
NAV_TIMEGPS: Final = 14
TXT: Final = 15
PASHR: Final = 16
"""Heading, roll and pitch with their accuracies."""
PASHR_HPR: Final = 17
PSAT_HPR: Final = 18
HPR: Final = 19
PTNL_AVR: Final = 20
"""Heading and tilt of the baseline, and its length."""
NONE: Final = -1
