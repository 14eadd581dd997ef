"""The solution on CAN: five classic frames, little endian, scaled integers that saturate.

    base + 0  latitude, longitude                      int32, 1e-7 deg
    base + 1  height above the ellipsoid, UTC of day   int32 mm, uint32 ms (0xFFFFFFFF: not known)
    base + 2  velocity north, east, down, speed        int16 × 3, uint16, 0.01 m/s
    base + 3  yaw, pitch, roll, yaw rate               uint16, int16 × 3, 0.01 deg and 0.01 deg/s
    base + 4  mode and counter, flags, sigmas          see `docs/link.md` and car_mems.dbc

The counter is one for all five frames of a set. Values are meant only when the mode is 3 (navigating) or 4
(degraded). Scaling is a kernel (`can_scaling`); the largest values of a field mean "that or more".
"""

from __future__ import annotations

from collections.abc import Sequence
from struct import Struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from firmware.link.can_scaling import INTEGERS, SOLUTION_FLOATS, scale_solution
from firmware.numerics.dialect import entry_point
from hal.can import CanFrame

BASE_IDENTIFIER: Final = 0x310
FRAME_BYTES: Final = 8
FRAME_COUNT: Final = 5
EIGHT_BYTES: Final = Struct("8s" * FRAME_COUNT).unpack
NOT_EXTENDED: Final = (False,) * FRAME_COUNT


class CanOutput:
    """Makes the five frames of a solution."""

    def __init__(self, base_identifier: int = BASE_IDENTIFIER) -> None:
        if not 0 <= base_identifier <= 0x7FF - FRAME_COUNT + 1:
            raise ValueError(
                f"CAN base identifier is {base_identifier:#x}; for {FRAME_COUNT} frames 0x0 … 0x7fb"
                " is possible"
            )
        self._identifiers = tuple(base_identifier + k for k in range(FRAME_COUNT))
        self._buffer = bytearray(FRAME_BYTES * FRAME_COUNT)
        self._bytes: NDArray[np.uint8] = np.frombuffer(self._buffer, np.uint8)
        self._floats = np.zeros(SOLUTION_FLOATS, np.float32)
        self._integers = np.zeros(INTEGERS, np.int64)
        self._counter = 0
        self._scale = entry_point(scale_solution)

    def frames(
        self,
        floats: NDArray[Any] | Sequence[float],
        lat_nanodeg: int,
        lon_nanodeg: int,
        time_of_day_ms: int,
        mode: int,
        flags: int,
    ) -> tuple[CanFrame, ...]:
        """The frames of one solution: `floats` is the float32 part of its record (19), m, m/s, rad, rad/s."""
        self._floats[:] = floats
        self._integers[:] = (lat_nanodeg, lon_nanodeg, time_of_day_ms, mode, flags, self._counter)
        self._counter = (self._counter + 1) & 15
        self._scale(self._floats, self._integers, self._bytes)
        columns = (self._identifiers, EIGHT_BYTES(self._buffer), NOT_EXTENDED)
        return tuple(map(CanFrame._make, zip(*columns, strict=True)))
