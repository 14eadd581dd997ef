"""One stream, two protocols: NMEA sentences and UBX frames taken apart byte by byte.

    hunting ──'$'──► sentence ──'*'──► two hexadecimal digits ──► apply
       └────0xB5───► frame ──length known, all there──► checksum ──► apply, or look again behind the 0xB5

Everything else is garbage and is counted. A sentence that is cut off by '$' or by a byte that is no
printable character is dropped there; one that grows beyond LONGEST_SENTENCE is dropped, too. A frame that
turns out not to be one (wrong second byte, absurd length, wrong checksum, or a silence in its middle) costs
only its first byte: what was read as its content is looked at again. So the result depends on the bytes and
on the silences between them, never on how the stream was cut into chunks.

Times: the caller gives the time at the end of the chunk's last byte; within a chunk bytes follow each other
at the baud rate.
"""

from typing import Final

import numpy as np

from firmware.drivers.epoch_grouping import silence
from firmware.drivers.nmea import which_sentence
from firmware.drivers.receiver_messages import apply_message
from firmware.drivers.receiver_state import (
    BAD_CHECKSUMS,
    BURST_NS,
    BYTE_NS,
    CHECK,
    CHUNK_END,
    CHUNK_NS,
    END_NS,
    FIELD,
    FIELD_COUNT,
    FIELD_LIMIT,
    FIRST_DIGIT,
    FRAME,
    GAP_NS,
    GARBAGE,
    HUNTING,
    LAST_BYTE_NS,
    LONGEST_FRAME,
    MESSAGE,
    MODE,
    NONE,
    OVERLONG,
    OVERRUNS,
    READY,
    RING_MASK,
    SECOND_DIGIT,
    SENTENCE,
    START,
    START_NS,
    TAKEN,
    TRUNCATED,
    UNKNOWN,
)
from firmware.drivers.ubx import HEADER, OVERHEAD, checksum, two_bytes, which_frame
from firmware.numerics.dialect import kernel

LONGEST_SENTENCE: Final = 255
"""NMEA allows 82; receivers with many decimals and PUBX sentences exceed it."""

DOLLAR: Final = ord("$")
STAR: Final = ord("*")
COMMA: Final = ord(",")
SYNC_1: Final = 0xB5
SYNC_2: Final = 0x62
CARRIAGE_RETURN: Final = 13
LINE_FEED: Final = 10


@kernel
def end_of_byte(s, at):
    """Time at the end of the byte at position `at`."""
    return s[CHUNK_NS] - (s[CHUNK_END] - 1 - at) * s[BYTE_NS]


@kernel
def begin_message(s, at, mode):
    """A sentence or a frame begins at position `at`."""
    s[MODE] = mode
    s[START] = at
    s[START_NS] = end_of_byte(s, at) - s[BYTE_NS]
    s[CHECK] = 0
    s[FIELD] = at + 1
    s[FIELD_COUNT] = 1


@kernel
def hunt(s, ring, position):
    """Between messages: look for the first byte of one, the rest is garbage; the next position."""
    mask = s[RING_MASK]
    end = s[CHUNK_END]
    at = position
    garbage = np.int64(0)
    while at < end:
        c = np.int64(ring[at & mask])
        if c == DOLLAR:
            begin_message(s, at, SENTENCE)
            end = at
        elif c == SYNC_1:
            begin_message(s, at, FRAME)
            end = at
        elif c != CARRIAGE_RETURN and c != LINE_FEED:
            garbage += 1
        at += 1
    s[GARBAGE] += garbage
    return at


@kernel
def within_sentence(s, ring, position):
    """The characters of a sentence up to its star; the next position to look at."""
    mask = s[RING_MASK]
    limit = s[START] + LONGEST_SENTENCE
    end = min(s[CHUNK_END], limit)
    at = position
    check = s[CHECK]
    while at < end:
        c = np.int64(ring[at & mask])
        if c == STAR:
            s[FIELD + s[FIELD_COUNT]] = at + 1
            s[MODE] = FIRST_DIGIT
            s[CHECK] = check
            return at + 1
        if c < 32 or c > 126 or c == DOLLAR:
            s[TRUNCATED] += 1
            s[MODE] = HUNTING
            return at
        if c == COMMA and s[FIELD_COUNT] < FIELD_LIMIT:
            s[FIELD + s[FIELD_COUNT]] = at + 1
            s[FIELD_COUNT] += 1
        check ^= c
        at += 1
    s[CHECK] = check
    if at == limit:
        s[OVERLONG] += 1
        s[MODE] = HUNTING
    return at


@kernel
def hexadecimal(c):
    """Value of a hexadecimal digit of either case, or −1."""
    lower = c | 32
    if c >= ord("0") and c <= ord("9"):
        return c - ord("0")
    if lower >= ord("a") and lower <= ord("f"):
        return lower - (ord("a") - 10)
    return np.int64(-1)


@kernel
def within_checksum(s, ring, c, at):
    """One of the two digits behind the star; the next position to look at."""
    digit = hexadecimal(c)
    if digit < 0:
        s[BAD_CHECKSUMS] += 1
        s[MODE] = HUNTING
        return at
    if s[MODE] == FIRST_DIGIT:
        s[CHECK] ^= digit << 4
        s[MODE] = SECOND_DIGIT
        return at + 1
    s[MODE] = HUNTING
    if s[CHECK] != digit:
        s[BAD_CHECKSUMS] += 1
    elif s[CHUNK_END] - s[START] > s[RING_MASK] + 1:
        s[OVERRUNS] += 1
    else:
        s[END_NS] = end_of_byte(s, at)
        s[MESSAGE] = which_sentence(s, ring)
    return at + 1


@kernel
def no_frame(s):
    """What began like a frame is none; look again behind its first byte."""
    s[GARBAGE] += 1
    s[MODE] = HUNTING
    return s[START] + 1


@kernel
def within_frame(s, ring):
    """Look at the frame that has begun; the next position to look at (the chunk's end: wait for more)."""
    mask = s[RING_MASK]
    start = s[START]
    there = s[CHUNK_END] - start
    length = np.int64(0)
    wrong = there > 1 and np.int64(ring[(start + 1) & mask]) != SYNC_2
    if there > mask + 1:
        s[OVERRUNS] += 1
        wrong = True
    elif there >= HEADER and not wrong:
        length = two_bytes(ring, mask, start + 4)
        if length + OVERHEAD > s[LONGEST_FRAME]:
            s[UNKNOWN] += 1
            wrong = True
    if not wrong and there < length + OVERHEAD:
        return s[CHUNK_END]
    behind = start + HEADER + length
    if not wrong and checksum(ring, mask, start + 2, length + 4) != two_bytes(ring, mask, behind):
        s[BAD_CHECKSUMS] += 1
        wrong = True
    if wrong:
        return no_frame(s)
    s[MODE] = HUNTING
    s[END_NS] = end_of_byte(s, behind + 1)
    s[MESSAGE] = which_frame(s, ring, start, length)
    return behind + 2


@kernel
def look_on(s, ring, at):
    """Look on from position `at`, at most to CHUNK_END; the next position.

    A message that was received in full meanwhile is then in MESSAGE.
    """
    mode = s[MODE]
    if mode == SENTENCE:
        return within_sentence(s, ring, at)
    if mode == FRAME:
        return within_frame(s, ring)
    if mode == HUNTING:
        return hunt(s, ring, at)
    return within_checksum(s, ring, np.int64(ring[at & s[RING_MASK]]), at)


@kernel
def take_in(s, end, now_ns):
    """Note that bytes up to `end` have come, the last one ending at `now_ns`."""
    if end > s[TAKEN]:
        s[TAKEN] = end
        s[LAST_BYTE_NS] = now_ns
    s[CHUNK_END] = s[TAKEN]
    s[CHUNK_NS] = s[LAST_BYTE_NS]


@kernel
def burst_is_over(s, epoch, first_bit_ns):
    """Everything before a silence has been looked at; its next burst begins at `first_bit_ns`."""
    silence(s, epoch)
    s[BURST_NS] = first_bit_ns


@kernel("int64(int64[::1], uint8[::1], int64, int64, int64, int64[::1])")
def demultiplex(s, ring, position, end, now_ns, epoch):
    """Take the bytes from `position` to `end` (stream positions) apart.

    s (STATE_SIZE,) state · ring DMA ring · now_ns time at the end of the last byte, or simply now when
    there are no new bytes (then only the silence is looked at) · epoch (RECORD_SIZE,) out, see READY.

    Returns the position to go on from. When an epoch is complete, READY is 1 and the return is early:
    use the record, then call again with the position returned and the same `end` and `now_ns`.
    """
    s[READY] = 0
    first_bit_ns = now_ns - (end - s[TAKEN]) * s[BYTE_NS]
    silent = first_bit_ns - s[LAST_BYTE_NS] > s[GAP_NS]
    take_in(s, s[TAKEN] if silent else end, now_ns)
    at = position
    while s[READY] == 0 and (silent or at < s[CHUNK_END]):
        if at < s[CHUNK_END]:
            s[MESSAGE] = NONE
            at = look_on(s, ring, at)
            if s[MESSAGE] != NONE:
                apply_message(s, ring, epoch)
        elif s[MODE] == FRAME:
            # cut off by the silence
            at = no_frame(s)
        else:
            burst_is_over(s, epoch, first_bit_ns)
            take_in(s, end, now_ns)
            silent = False
    return at
