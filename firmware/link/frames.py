"""Frames to the host: layout of each payload, and the writer that packs, numbers and seals them.

    A5 5A | type | length | sequence | payload | CRC-16 low, high        all numbers little endian

The CRC covers type … payload. `docs/link.md` has the byte tables. Times are of the board's clock, µs since
reset; angles rad, lengths m, unless the name of a field says otherwise.
"""

from __future__ import annotations

from struct import Struct

import numpy as np
from numpy.typing import NDArray

from firmware.link.crc import crc16

SYNC = b"\xa5\x5a"
HEADER_LENGTH = 5
CRC_LENGTH = 2
LONGEST_PAYLOAD = 255

SOLUTION = 0x01
COVARIANCE = 0x02
INNOVATION = 0x03
BIAS = 0x04
STATUS = 0x05
GNSS = 0x06
TEXT = 0x08

NO_DATE = 0xFFFF
NO_TIME_OF_DAY = 0xFFFFFFFF

PAYLOADS = {
    SOLUTION: Struct("<QIHBHqqf18f"),
    COVARIANCE: Struct("<Q45f"),
    INNOVATION: Struct("<QB12f"),
    BIAS: Struct("<Q18f"),
    STATUS: Struct("<QBHIIIIHHHBB"),
    GNSS: Struct("<QIHHqqiiIIiiiBHII"),
}
"""Payload of each type with fixed length; TEXT is UTF-8."""


class FrameWriter:
    """Packs frames into one buffer; `frame` of the last one is valid until the next."""

    def __init__(self) -> None:
        self._buffer = bytearray(HEADER_LENGTH + LONGEST_PAYLOAD + CRC_LENGTH)
        self._buffer[0:2] = SYNC
        self._bytes: NDArray[np.uint8] = np.frombuffer(self._buffer, np.uint8)
        self._view = memoryview(self._buffer)
        self._sequence = 0

    def pack(self, kind: int, *values: float) -> bytes:
        """A frame of fixed length; values in the order of its layout."""
        layout = PAYLOADS[kind]
        layout.pack_into(self._buffer, HEADER_LENGTH, *values)
        return self._seal(kind, layout.size)

    def text(self, message: str) -> bytes:
        """A TEXT frame; what is too long is cut."""
        payload = message.encode()[:LONGEST_PAYLOAD]
        self._buffer[HEADER_LENGTH : HEADER_LENGTH + len(payload)] = payload
        return self._seal(TEXT, len(payload))

    def _seal(self, kind: int, length: int) -> bytes:
        buffer = self._buffer
        buffer[2] = kind
        buffer[3] = length
        buffer[4] = self._sequence
        self._sequence = (self._sequence + 1) & 0xFF
        end = HEADER_LENGTH + length
        crc = crc16(self._bytes, 2, end)
        buffer[end] = crc & 0xFF
        buffer[end + 1] = crc >> 8
        return bytes(self._view[: end + CRC_LENGTH])
