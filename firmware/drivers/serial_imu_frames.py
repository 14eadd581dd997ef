"""Frames of the serial inertial unit, taken out of the DMA ring where they lie.

    AA 55 | counter | Δθ x, y, z | Δv x, y, z | status | CRC        32 bytes, little endian (docs/fidelity)

A frame counts when its CRC over counter … status is right; otherwise the search goes on behind its first
byte. Positions are counts of bytes since reception started; position & mask is the index into the ring.
"""

from typing import Final

import numpy as np

from firmware.numerics.dialect import kernel

FRAME_LENGTH: Final = 32
SYNC_1: Final = 0xAA
SYNC_2: Final = 0x55
COUNTER_MASK: Final = 0xFFFF

# A sample, int64.
COUNTER: Final = 0
ANGLE: Final = 1
"""Δθ x, y, z in 10⁻⁹ rad, sensor axes, since the sample before."""
VELOCITY: Final = 4
"""Δv x, y, z in 10⁻⁸ m/s."""
STATUS: Final = 7
END_NS: Final = 8
"""Board clock at the last bit of its frame."""
MISSED: Final = 9
"""Samples missing before it, by the counter."""
SAMPLE_SIZE: Final = 10

GYRO_RANGE: Final = 1
ACCEL_RANGE: Final = 2
STARTING: Final = 4
SELF_TEST_FAILED: Final = 8
"""Bits of STATUS."""

# The state of a stream, int64.
MASK: Final = 0
"""Length of the ring − 1."""
BYTE_NS: Final = 1
GARBAGE: Final = 2
"""Bytes outside good frames."""
FRAMES: Final = 3
BAD_CHECKS: Final = 4
LOST: Final = 5
"""Samples missing by the counter, altogether."""
READY: Final = 6
LAST_COUNTER: Final = 7
"""−1 before the first frame."""
CUT: Final = 8
STATE_SIZE: Final = 9

RADIAN: Final = np.float32(1e-9)
METRE_PER_SECOND: Final = np.float32(1e-8)


@kernel
def crc_of_frame(ring, mask, begin, length):
    """CRC-16/CCITT-FALSE of `length` bytes from a position on."""
    crc = np.int64(0xFFFF)
    for i in range(np.int32(length)):
        x = (crc >> 8) ^ np.int64(ring[(begin + i) & mask])  # as in firmware.link.crc
        x ^= x >> 4
        crc = ((crc << 8) ^ (x << 12) ^ (x << 5) ^ x) & 0xFFFF
    return crc


@kernel
def unsigned(ring, mask, begin, count):
    """A little-endian number of `count` bytes."""
    value = np.int64(0)
    for i in range(np.int32(count)):
        value |= np.int64(ring[(begin + i) & mask]) << (8 * i)
    return value


@kernel
def may_begin(ring, mask, at, end):
    """Whether the bytes from `at` on begin with the sync, as far as they have come."""
    second = at + 1 >= end or np.int64(ring[(at + 1) & mask]) == SYNC_2
    return second and np.int64(ring[at & mask]) == SYNC_1


@kernel
def take_frame(s, ring, begin, sample):
    """Write the good frame at `begin` into `sample`."""
    mask = s[MASK]
    counter = unsigned(ring, mask, begin + 2, np.int64(2))
    sample[COUNTER] = counter
    for axis in range(np.int32(6)):
        value = unsigned(ring, mask, begin + 4 + 4 * axis, np.int64(4))
        sample[ANGLE + axis] = (value ^ 0x8000_0000) - 0x8000_0000
    sample[STATUS] = unsigned(ring, mask, begin + 28, np.int64(2))
    missed = np.int64(0)
    if s[LAST_COUNTER] >= 0:
        missed = (counter - s[LAST_COUNTER] - 1) & COUNTER_MASK
    sample[MISSED] = missed
    s[LOST] += missed
    s[LAST_COUNTER] = counter
    s[FRAMES] += 1


@kernel("int64(int64[::1], uint8[::1], int64, int64, int64, int64[::1])")
def find_frame(s, ring, position, end, end_ns, sample):
    """Look for a frame from `position` to `end`; `end_ns` is the time of the last byte.

    s (STATE_SIZE,) state · ring the DMA ring · sample (SAMPLE_SIZE,) out, when READY becomes 1: use it and
    call again. Returns the position to go on from. With CUT 1 the line fell silent at `end`: what is not
    complete there never will be.
    """
    mask = s[MASK]
    at = position
    s[READY] = 0
    while at < end:
        if not may_begin(ring, mask, at, end):
            s[GARBAGE] += 1
            at += 1
        elif at + FRAME_LENGTH > end:
            if s[CUT] == 0:
                return at
            s[GARBAGE] += 1
            at += 1
        else:
            told = unsigned(ring, mask, at + 30, np.int64(2))
            if crc_of_frame(ring, mask, at + 2, np.int64(28)) == told:
                take_frame(s, ring, at, sample)
                sample[END_NS] = end_ns - (end - at - FRAME_LENGTH) * s[BYTE_NS]
                s[READY] = 1
                return at + FRAME_LENGTH
            s[BAD_CHECKS] += 1
            s[GARBAGE] += 1
            at += 1
    return at


@kernel("void(int64[::1], float32[::1])")
def increments(sample, out):
    """out (6,): Δθ x, y, z in rad, Δv x, y, z in m/s of a sample."""
    for axis in range(np.int32(3)):
        out[axis] = np.float32(np.int32(sample[ANGLE + axis])) * RADIAN
        out[axis + 3] = np.float32(np.int32(sample[VELOCITY + axis])) * METRE_PER_SECOND
