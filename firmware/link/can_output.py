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

from typing import Final

BASE_IDENTIFIER: Final = 0x310
FRAME_COUNT: Final = 5


def identifiers(base: int) -> tuple[int, ...]:
    """Of the frames of a set. ValueError when they do not fit into 11 bits."""
    if not 0 <= base <= 0x7FF - FRAME_COUNT + 1:
        raise ValueError(
            f"CAN base identifier is {base:#x}; for {FRAME_COUNT} frames 0x0 … 0x7fb is possible"
        )
    return tuple(base + k for k in range(FRAME_COUNT))
