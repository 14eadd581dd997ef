"""Sections of numbers in flash, in two blocks that are written in turn.

    magic "GFSC"   version   length of the sections   generation   sections …   CRC
    a section:     tag       how many                 numbers of 32 bits

All of a block is written anew each time, into the one that does not hold the newest. A power cut therefore
leaves what was stored before; a block whose check sum is wrong does not count.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from struct import Struct
from typing import Final

from firmware.apps.gfsins.settings_packet import SUM, check_sum
from hal.flash import FlashMemory

MAGIC: Final = b"GFSC"
VERSION: Final = 1
HEAD: Final = Struct(">4sHHI")
SECTION: Final = Struct(">BB")
NUMBER_BYTES: Final = 4
CLEAR: Final = b"\xff"

Sections = dict[int, bytes]
"""By tag, numbers as they are packed."""


class Found(Enum):
    """What was there at power-up."""

    NOTHING = "no calibration"
    GOOD = "calibration loaded"
    SPOILT = "calibration spoilt, not used"


class CalibrationStore:
    """Both blocks."""

    def __init__(self, flash: FlashMemory) -> None:
        self.found = Found.NOTHING
        self.generation = 0
        """Of what was loaded or saved last; it counts up."""
        self._flash = flash
        self._newest = -1

    def load(self) -> Sections:
        """The newest that is whole; empty when there is none."""
        newest: Sections = {}
        self._newest, self.generation, written = -1, 0, False
        for block in range(self._flash.blocks):
            data = self._flash.read(block * self._flash.block_bytes, self._flash.block_bytes)
            written |= data.strip(CLEAR) != b""
            held = unpack(data)
            if held is not None and (self._newest < 0 or held[0] > self.generation):
                self.generation, newest = held
                self._newest = block
        good = Found.GOOD if self._newest >= 0 else Found.SPOILT
        self.found = good if written else Found.NOTHING
        return newest

    def save(self, sections: Mapping[int, bytes]) -> bool:
        """Takes some 30 ms. False: the memory did not take it; what was there before still is."""
        flash = self._flash
        block = (self._newest + 1) % flash.blocks
        data = pack(sections, self.generation + 1)
        start = block * flash.block_bytes
        if len(data) > flash.block_bytes or not flash.erase(block) or not flash.program(start, data):
            return False
        if flash.read(start, len(data)) != data:
            return False
        self.generation += 1
        self._newest, self.found = block, Found.GOOD
        return True


def pack(sections: Mapping[int, bytes], generation: int) -> bytes:
    """What a block begins with."""
    body = b"".join(SECTION.pack(tag, len(data) // NUMBER_BYTES) + data for tag, data in sections.items())
    data = HEAD.pack(MAGIC, VERSION, len(body), generation & 0xFFFFFFFF) + body
    return data + SUM.pack(check_sum(data))


def unpack(block: bytes) -> tuple[int, Sections] | None:
    """Generation and sections; None: nothing that this program has written."""
    magic, version, length, generation = HEAD.unpack_from(block)
    end = HEAD.size + length
    if magic != MAGIC or version != VERSION or end + SUM.size > len(block):
        return None
    if SUM.unpack_from(block, end)[0] != check_sum(block[:end]):
        return None
    sections: Sections = {}
    place = HEAD.size
    while place + SECTION.size <= end:
        tag, count = SECTION.unpack_from(block, place)
        place += SECTION.size
        sections[tag] = block[place : place + NUMBER_BYTES * count]
        place += NUMBER_BYTES * count
    return (generation, sections) if place == end else None
