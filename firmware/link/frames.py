"""Frames to the host: layout of each payload, and the writer that packs, numbers and seals them.

    A5 5A | type | length | sequence | payload | CRC-16 low, high        all numbers little endian

The CRC covers type … payload; one sequence number runs through all types. `docs/link.md` has the byte
tables. Times are of the board's clock, µs since reset; angles rad, lengths m, unless the name of a field
says otherwise.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from struct import Struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.satellite_lists import SYSTEM_NAMES, SatelliteInView
from firmware.link.crc import append_crc
from firmware.numerics.dialect import entry_point
from hal.machine_code import mypyc_attr

SYNC: Final = b"\xa5\x5a"
HEADER_LENGTH: Final = 5
CRC_LENGTH: Final = 2
LONGEST_PAYLOAD: Final = 255

SOLUTION: Final = 0x01
COVARIANCE: Final = 0x02
INNOVATION: Final = 0x03
BIAS: Final = 0x04
STATUS: Final = 0x05
GNSS: Final = 0x06
TASKS: Final = 0x07
TEXT: Final = 0x08
SATELLITES: Final = 0x09
ATTITUDE: Final = 0x0A
"""A solution in integers alone, of boards that compute attitude first of all."""
SENSOR: Final = 0x0B
"""The health of a sensor whose bursts tell it."""
FILTER: Final = 0x0C
"""What one of several filters side by side takes for the state."""

NO_DATE: Final = 0xFFFF
NO_TIME_OF_DAY: Final = 0xFFFF_FFFF
NOT_TOLD: Final = 0xFF
"""Elevation or C/N0 that the receiver left empty; an azimuth is then 0xFFFF."""

PAYLOADS: Final = {
    SOLUTION: Struct("<QIHBHqqf18f"),
    COVARIANCE: Struct("<Q45f"),
    INNOVATION: Struct("<QB12f"),
    BIAS: Struct("<Q18f"),
    STATUS: Struct("<QBHIIIIHHHBB"),
    GNSS: Struct("<QIHHqqiiIIiiiBHII"),
    ATTITUDE: Struct("<QBHHqqq12i"),
    SENSOR: Struct("<QHHhIIHHHHB23I"),
    FILTER: Struct("<QBBqq16f"),
}
"""Payloads of fixed length. TEXT is UTF-8; TASKS and SATELLITES are a head and rows."""

_HEADED: Final = {
    kind: (Struct("<BBB" + layout.format.removeprefix("<")), layout.size) for kind, layout in PAYLOADS.items()
}
"""The same behind type, length and sequence, and the payload's length."""

TIME_HEAD: Final = Struct("<Q")
"""What stands before the numbers of COVARIANCE and BIAS."""
INNOVATION_HEAD: Final = Struct("<QB")
LIST_HEAD: Final = Struct("<Q")
TASK_ROW: Final = Struct("<12sIIIH")
"""Name (UTF-8, zeros behind), activations, time worked µs modulo 2³², worst response µs, deadlines missed."""
SATELLITE_HEAD: Final = Struct("<QBB")
"""Time, number of this frame, frames in this list."""
SATELLITE_ROW: Final = Struct("<BHBHBB")
"""System (place in SYSTEM_NAMES), number, elevation °, azimuth °, C/N0 dBHz, 1 when used."""
TASK_ROWS_A_FRAME: Final = (LONGEST_PAYLOAD - LIST_HEAD.size) // TASK_ROW.size
SATELLITES_A_FRAME: Final = (LONGEST_PAYLOAD - SATELLITE_HEAD.size) // SATELLITE_ROW.size


@mypyc_attr(allow_interpreted_subclasses=True)
class FrameWriter:
    """Makes frames, numbered one after the other."""

    def __init__(self) -> None:
        self._buffer = bytearray(HEADER_LENGTH + LONGEST_PAYLOAD + CRC_LENGTH)
        self._buffer[0:2] = SYNC
        self._bytes: NDArray[np.uint8] = np.frombuffer(self._buffer, np.uint8)
        self._view = memoryview(self._buffer)
        self._append_crc = entry_point(append_crc)
        self._sequence = 0

    def pack(self, kind: int, *values: float) -> bytes:
        """A frame of fixed length; values in the order of its layout.

        Raises struct.error when their number or a value does not fit.
        """
        layout, length = _HEADED[kind]
        layout.pack_into(self._buffer, len(SYNC), kind, length, self._sequence, *values)
        return self._seal(length)

    def numbers(self, kind: int, head: bytes, numbers: NDArray[Any]) -> bytes:
        """A frame of fixed length that ends in float32 numbers, `head` what its layout has before them."""
        return self._copy(kind, head + np.asarray(numbers, "<f4").tobytes())

    def frame(self, kind: int, payload: bytes) -> bytes:
        """A frame of any type from its payload, at most LONGEST_PAYLOAD bytes."""
        return self._copy(kind, payload)

    def text(self, message: str) -> bytes:
        """A TEXT frame; what is too long is cut at a whole character."""
        payload = message.encode()[:LONGEST_PAYLOAD].decode(errors="ignore").encode()
        return self._copy(TEXT, payload)

    def tasks(self, time_us: int, rows: Iterable[tuple[str, int, int, int, int]]) -> Iterator[bytes]:
        """TASKS frames: (name, activations, time worked in µs, worst response in µs, deadlines missed)."""
        packed = [TASK_ROW.pack(name.encode()[:12], *figures) for name, *figures in rows]
        for first in range(0, len(packed), TASK_ROWS_A_FRAME):
            part = b"".join(packed[first : first + TASK_ROWS_A_FRAME])
            yield self._copy(TASKS, LIST_HEAD.pack(time_us) + part)

    def satellites(self, time_us: int, seen: Iterable[SatelliteInView]) -> Iterator[bytes]:
        """SATELLITES frames: the satellites in view; one empty frame when there are none."""
        packed = [_satellite_row(satellite) for satellite in seen]
        frames = max(1, -(-len(packed) // SATELLITES_A_FRAME))
        for number in range(frames):
            part = b"".join(packed[number * SATELLITES_A_FRAME : (number + 1) * SATELLITES_A_FRAME])
            yield self._copy(SATELLITES, SATELLITE_HEAD.pack(time_us, number, frames) + part)

    def next_sequence(self) -> int:
        """Number of a frame that is packed elsewhere."""
        sequence = self._sequence
        self._sequence = (sequence + 1) & 0xFF
        return sequence

    def _copy(self, kind: int, payload: bytes) -> bytes:
        length = len(payload)
        buffer = self._buffer
        buffer[len(SYNC) : HEADER_LENGTH] = bytes((kind, length, self._sequence))
        buffer[HEADER_LENGTH : HEADER_LENGTH + length] = payload
        return self._seal(length)

    def _seal(self, length: int) -> bytes:
        self._sequence = (self._sequence + 1) & 0xFF
        end = HEADER_LENGTH + length
        self._append_crc(self._bytes, len(SYNC), end)
        return bytes(self._view[: end + CRC_LENGTH])


def _satellite_row(satellite: SatelliteInView) -> bytes:
    elevation, azimuth, cn0 = satellite.elevation_deg, satellite.azimuth_deg, satellite.cn0_dbhz
    return SATELLITE_ROW.pack(
        SYSTEM_NAMES.index(satellite.system),
        satellite.number,
        NOT_TOLD if elevation is None else min(elevation, 90),
        0xFFFF if azimuth is None else azimuth,
        NOT_TOLD if cn0 is None else min(cn0, NOT_TOLD - 1),
        satellite.used,
    )
