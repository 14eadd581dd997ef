"""Makes ATTITUDE frames of solution records."""

from __future__ import annotations

from struct import Struct
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.link import attitude_packing as place
from firmware.link.frames import ATTITUDE, PAYLOADS, SYNC, FrameWriter
from firmware.numerics.dialect import entry_point

PACK_WORDS: Final = Struct(f"={place.WORDS}q").pack_into
UNKNOWN_AGE: Final = 0xFFFF


class AttitudeOutput:
    """Owns the buffer that the kernel fills."""

    def __init__(self, writer: FrameWriter) -> None:
        self._writer = writer
        self._buffer = bytearray(place.FRAME_BYTES)
        self._buffer[: place.SEQUENCE_AT] = SYNC + bytes((ATTITUDE, PAYLOADS[ATTITUDE].size))
        self._data: NDArray[np.uint8] = np.frombuffer(self._buffer, np.uint8)
        self._word_bytes = bytearray(8 * place.WORDS)
        self._words: NDArray[np.int64] = np.frombuffer(self._word_bytes, np.int64)
        self._pack = entry_point(place.pack_attitude)

    def pack(self, record: NDArray[np.int64], time_us: int, mode: int, flags: int, age_us: int) -> bytes:
        """The frame of a record of `firmware.nav.attitude` (layout.OUT_…) that held at `time_us`."""
        PACK_WORDS(self._word_bytes, 0, time_us, mode, flags, age_us, self._writer.next_sequence())
        pack = self._pack
        pack(record, self._words, self._data)
        return bytes(self._buffer)
