"""Packs a solution once for both ports: a SOLUTION frame for the host, and the set of CAN frames."""

from __future__ import annotations

from struct import Struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from firmware.link import solution_packing as place
from firmware.link.can_output import BASE_IDENTIFIER, identifiers
from firmware.link.frames import PAYLOADS, SOLUTION, SYNC, FrameWriter
from firmware.numerics.dialect import entry_point
from hal.can import CanSet
from hal.machine_code import mypyc_attr

FLOAT32: Final = np.dtype(np.float32)
PACK_WORDS: Final = Struct(f"={place.WORDS}q").pack_into


@mypyc_attr(allow_interpreted_subclasses=True)
class SolutionOutput:
    """Owns the buffer that one kernel fills. ValueError for a base identifier without room for a set."""

    def __init__(self, writer: FrameWriter, base_identifier: int = BASE_IDENTIFIER) -> None:
        self._writer = writer
        self._identifiers = identifiers(base_identifier)
        self._counter = 0
        self._buffer = bytearray(place.SIZE)
        head = SYNC + bytes((SOLUTION, PAYLOADS[SOLUTION].size))
        self._buffer[place.FRAME_AT : place.SEQUENCE_AT] = head
        self._frame = memoryview(self._buffer)[place.FRAME_AT : place.FRAME_END]
        self._can = memoryview(self._buffer)[place.CAN_AT :]
        self._data: NDArray[np.uint8] = np.frombuffer(self._buffer, np.uint8)
        self._numbers: NDArray[np.float32] = np.frombuffer(self._buffer, np.float32)
        self._word_bytes = bytearray(8 * place.WORDS)
        self._words: NDArray[np.int64] = np.frombuffer(self._word_bytes, np.int64)
        self._pack = entry_point(place.pack_solution)

    def pack(
        self,
        floats: NDArray[Any],
        integers: NDArray[np.int64],
        time_us: int,
        time_of_day_ms: int,
        date_days: int,
    ) -> tuple[bytes, CanSet]:
        """(frame, CAN set) of a solution record: `floats` (19) m, m/s, rad, rad/s, `integers` (5)."""
        counter = self._counter
        self._counter = (counter + 1) & 15
        PACK_WORDS(
            self._word_bytes, 0, time_us, time_of_day_ms, date_days, self._writer.next_sequence(), counter
        )
        pack = self._pack
        if floats.dtype is not FLOAT32:
            floats = floats.astype(FLOAT32)
        pack(floats, integers, self._words, self._data, self._numbers)
        return bytes(self._frame), CanSet(self._identifiers, bytes(self._can))
