"""The stream of bus words that all arithmetics get: every burst of the ADIS16407 in a capture.

A burst is a chip-select low period that begins with the word 0x4200 and has 14 more (fact sheet section 2).
The answer is taken as it stood on the wire; nothing is decoded here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.capture.blocks import SPI_HEAD
from host.capture.reader import CaptureReader
from host.record.errors import UserError

BURST = b"\x42" + bytes(29)


@dataclass(frozen=True, slots=True)
class Bursts:
    """Some bursts in a row."""

    times_ns: NDArray[np.int64]
    """When chip select went low."""
    raw: NDArray[np.uint8]
    """(n, 30): what came back, the word of the request first."""

    def __len__(self) -> int:
        return len(self.times_ns)


def bursts_of(capture: Path) -> Iterator[Bursts]:
    """All bursts of a capture, window by window, those of the first bus that has any.

    Raises UserError for a file that is no capture, or without bursts.
    """
    reader = CaptureReader(capture)
    bus = None
    for window in reader.windows():
        for topic, block in window.raw.items():
            if reader.raw_schema(topic) != "navtwin.SpiBlock" or (bus is not None and topic != bus):
                continue
            found = _bursts_in(block)
            if len(found):
                bus = topic
                yield found
    if bus is None:
        raise UserError(
            f"capture {capture}: holds no burst of an ADIS16407 (0x4200 and 14 words); for example"
            " runs/uav_ahrs-flight-float32-1/run.mcap"
        )


def _bursts_in(block: bytes) -> Bursts:
    """Those among the records of a block (`host.capture.blocks`)."""
    times, answers = [], bytearray()
    place = 0
    while place < len(block):
        start_ns, _, count = SPI_HEAD.unpack_from(block, place)
        mosi = place + SPI_HEAD.size
        place = mosi + 2 * count
        if count == len(BURST) and block[mosi : mosi + count] == BURST:
            times.append(start_ns)
            answers += block[mosi + count : place]
    raw = np.frombuffer(bytes(answers), np.uint8).reshape(-1, len(BURST))
    return Bursts(np.array(times, np.int64), raw)
