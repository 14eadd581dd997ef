"""UBX frames: which one is this, and frames for sending (fact sheet section 4).

B5 62 | class | id | length, 2 bytes | payload | CK_A CK_B      little endian
checksum: 8-bit Fletcher over class … payload
"""

from typing import Final

import numpy as np

from firmware.drivers.receiver_state import (
    ACK_OF,
    ACKS,
    FRAMES,
    MESSAGE_ROW,
    MESSAGES,
    NAK_OF,
    NAKS,
    NAV_PVT,
    NAV_TIMEGPS,
    NONE,
    RING_MASK,
    UNKNOWN,
    VERSIONS,
)
from firmware.numerics.dialect import kernel

SYNC: Final = b"\xb5\x62"
HEADER: Final = 6
OVERHEAD: Final = 8
"""Bytes of a frame besides its payload."""

ACK_ACK: Final = 0x0501
ACK_NAK: Final = 0x0500
MON_VER: Final = 0x0A04
NAV_PVT_LENGTH: Final = 92
NAV_TIMEGPS_LENGTH: Final = 16


def frame(message: int, payload: bytes = b"") -> bytes:
    """A whole frame; `message` is class << 8 | id."""
    body = bytes((message >> 8, message & 0xFF)) + len(payload).to_bytes(2, "little") + payload
    a = b = 0
    for byte in body:
        a = (a + byte) & 0xFF
        b = (b + a) & 0xFF
    return SYNC + body + bytes((a, b))


@kernel
def checksum(ring, mask, begin, count):
    """Fletcher checksum of `count` bytes from position `begin`, as CK_B << 8 | CK_A."""
    a = np.int64(0)
    b = np.int64(0)
    for i in range(np.int32(count)):
        a += np.int64(ring[(begin + i) & mask])
        b += a
    return (b & 0xFF) << 8 | (a & 0xFF)


@kernel
def two_bytes(ring, mask, position):
    """Little-endian number of two bytes."""
    return np.int64(ring[position & mask]) | np.int64(ring[(position + 1) & mask]) << 8


@kernel
def which_frame(s, ring, begin, length):
    """The message that a frame of `length` payload bytes at position `begin` is, its checksum proven.

    NONE for acknowledgements and versions, which are counted for the configuration of the receiver, and
    for unknown frames.
    """
    mask = s[RING_MASK]
    code = np.int64(ring[(begin + 2) & mask]) << 8 | np.int64(ring[(begin + 3) & mask])
    about = np.int64(ring[(begin + HEADER) & mask]) << 8 | np.int64(ring[(begin + HEADER + 1) & mask])
    if code == s[MESSAGES + NAV_PVT * MESSAGE_ROW] and length == NAV_PVT_LENGTH:
        return np.int64(NAV_PVT)
    if code == s[MESSAGES + NAV_TIMEGPS * MESSAGE_ROW] and length == NAV_TIMEGPS_LENGTH:
        return np.int64(NAV_TIMEGPS)
    if code == ACK_ACK and length == 2:
        s[ACKS] += 1
        s[ACK_OF] = about
    elif code == ACK_NAK and length == 2:
        s[NAKS] += 1
        s[NAK_OF] = about
    elif code == MON_VER and length > 0:
        s[VERSIONS] += 1
    else:
        s[UNKNOWN] += 1
        return np.int64(NONE)
    s[FRAMES] += 1
    return np.int64(NONE)
