"""Pictures of a board's display: what stood on it from when on, and as PNG.

A grey picture as PNG is a signature and three chunks, so no image library is needed for it.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
"""(rows, columns) grey levels 0 … 15."""

BRIGHTEST = 15
SIGNATURE = b"\x89PNG\r\n\x1a\n"
BITS = 8
GREY = 0
FILE_SCALE = 4


@dataclass(frozen=True, slots=True)
class Screen:
    """What a display showed from an instant on."""

    time_ns: int
    picture: Picture


def file_name(number: int) -> str:
    """Of the PNG of the screen `number`, from 1."""
    return f"screen-{number:03d}.png"


def png(picture: Picture, scale: int = 1) -> bytes:
    """The picture, each pixel a square of `scale` × `scale`."""
    grey = (picture.astype(np.uint16) * 255 // BRIGHTEST).astype(np.uint8)
    large = np.repeat(np.repeat(grey, scale, axis=0), scale, axis=1)
    rows, columns = large.shape
    unfiltered = np.zeros((rows, columns + 1), np.uint8)
    unfiltered[:, 1:] = large
    head = struct.pack(">IIBBBBB", columns, rows, BITS, GREY, 0, 0, 0)
    body = zlib.compress(unfiltered.tobytes(), 9)
    return SIGNATURE + _chunk(b"IHDR", head) + _chunk(b"IDAT", body) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
