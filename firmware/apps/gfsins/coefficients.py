"""The DSP's share of the calibration on its way from the FPGA: a coefficient with each packet.

    word 43   which, from 1        44-45   float32        46   how many << 8 | generation of the store

Round and round for ever, so that neither a lost packet nor a DSP that begins anew needs a protocol. Words of
an FPGA without a calibration are 0, and nothing is waited for; word 46 is SPOILT where there was one that is
not whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from struct import Struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from firmware.nav.gyro_free import layout as gl

FIRST_WORD: Final = 43
WORDS: Final = 4
PLACES: Final = ((gl.OFFSET, 9), (gl.FORCE_MATRIX, 9), (gl.RATE_MATRIX, 9), (gl.COMPASS_DEVIATION, 5))
"""Where they belong in the sensor's array: what the FPGA's whole words leave of the offsets, then the
matrices of force and rate, the deviation."""
COUNT: Final = sum(count for _, count in PLACES)
SPOILT: Final = 0xFFFF
NUMBER: Final = Struct(">f")
HALVES: Final = Struct(">HH")


def packet_words(values: Sequence[float], generation: int) -> NDArray[np.int64]:
    """(COUNT, WORDS): what the packets carry one after the other."""
    last = len(values) << 8 | generation & 0xFF
    rows = [(k, *HALVES.unpack(NUMBER.pack(value)), last) for k, value in enumerate(values, start=1)]
    return np.array(rows, np.int64)


class Coefficients:
    """Gathers them at the DSP, until they are all there."""

    def __init__(self, g: NDArray[Any]) -> None:
        self.is_used = False
        """They are in the sensor's array."""
        self.is_spoilt = False
        """The FPGA has told so."""
        self._g = g
        self._found: dict[int, float] = {}
        self._last = 0

    def take(self, words: NDArray[np.int64]) -> bool:
        """A packet; False: there are some, and they are not all here yet."""
        which, high, low, last = words[FIRST_WORD : FIRST_WORD + WORDS].tolist()
        self.is_spoilt |= last == SPOILT
        if not which or last >> 8 != COUNT or (self.is_used and last == self._last):
            return True
        if last != self._last:
            self._last = last
            self.is_used = False
            self._found.clear()
        self._found[which - 1] = NUMBER.unpack(HALVES.pack(high, low))[0]
        if len(self._found) < COUNT:
            return False
        values = [self._found[k] for k in range(COUNT)]
        for place, count in PLACES:
            self._g[place : place + count] = values[:count]
            del values[:count]
        self.is_used = True
        return True
