"""CAN: the level on the bus and what each sender drives, from data frames.

Level 1 is recessive, 0 dominant, as at the RXD and TXD pins of a transceiver. Between start of frame and the
end of the CRC every five equal bits are followed by one of the other level. The acknowledge slot is dominant
on the bus, because the frames of a capture got through, and recessive at TXD of the sender. A frame of N bits
that ended at t has its bit k at t − ⌊(N − k)·10⁹/bit rate⌋ (CAN specification 2.0, part B).
"""

from __future__ import annotations

from typing import Any

from hal.emulated.virtual_time import SECOND
from host.capture.blocks import CanMessage, Traffic
from host.waves.lines import Edge, Level, Unit

BUS = 0
CRC_BITS = 15
CRC_POLYNOMIAL = 0x4599
LONGEST_RUN = 5
ACKNOWLEDGE_SLOT = -9
"""Place of the slot, counted from the end of the frame."""


class CanLines:
    """One bus with the nodes that sent something."""

    kind = "can"
    gap_ns = 0

    def __init__(self, name: str, bitrate: int, senders: list[str]) -> None:
        self.name = name
        self.bitrate = bitrate
        self._senders = {sender: 1 + k for k, sender in enumerate(senders)}
        self.lines = [f"{name}_bus", *(f"{name}_tx_{sender}" for sender in senders)]
        self.idle: list[Level] = [1] * len(self.lines)
        self.lanes = [list(range(len(self.lines)))]

    def units(self, record: Traffic) -> list[Unit]:
        """A frame."""
        assert isinstance(record, CanMessage)
        bits = frame_levels(record.identifier, record.extended, record.data)
        begin = record.end_ns - len(bits) * SECOND // self.bitrate
        return [Unit(begin, record.end_ns, 0, (bits, record.sender))]

    def edges(self, unit: Unit) -> list[Edge]:
        """Every change of level on the bus, and at the sender."""
        bits, sender = unit.content
        edges = self._changes(unit.end_ns, BUS, bits)
        line = self._senders.get(sender)
        if line is not None:
            sent = [*bits]
            sent[ACKNOWLEDGE_SLOT] = 1
            edges = sorted(edges + self._changes(unit.end_ns, line, sent))
        return edges

    def facts(self) -> dict[str, Any]:
        """Bit rate."""
        return {"bitrate": self.bitrate}

    def _changes(self, end_ns: int, line: int, bits: list[int]) -> list[Edge]:
        count, level = len(bits), 1
        changes = []
        for place, bit in enumerate(bits):
            if bit != level:
                level = bit
                changes.append(Edge(end_ns - (count - place) * SECOND // self.bitrate, line, level))
        return changes


def frame_levels(identifier: int, extended: bool, data: bytes) -> list[int]:
    """Levels of a data frame from start of frame to end of frame, stuff bits included.

    Raises ValueError for a frame that CAN 2.0 does not have.
    """
    limit = 0x1FFF_FFFF if extended else 0x7FF
    if not 0 <= identifier <= limit or len(data) > 8:
        raise ValueError(f"CAN frame 0x{identifier:X} with {len(data)} bytes: CAN 2.0 has no such frame")
    if extended:
        header = [0, *_bits(identifier >> 18, 11), 1, 1, *_bits(identifier & 0x3FFFF, 18), 0, 0, 0]
    else:
        header = [0, *_bits(identifier, 11), 0, 0, 0]
    content = [*header, *_bits(len(data), 4), *(bit for byte in data for bit in _bits(byte, 8))]
    trailer = [1, 0, 1, *[1] * 7]
    return _stuffed([*content, *_bits(_crc(content), CRC_BITS)]) + trailer


def _bits(value: int, count: int) -> list[int]:
    return [value >> shift & 1 for shift in range(count - 1, -1, -1)]


def _crc(content: list[int]) -> int:
    crc = 0
    for bit in content:
        feedback = bit ^ crc >> (CRC_BITS - 1)
        crc = crc << 1 & 0x7FFF
        if feedback:
            crc ^= CRC_POLYNOMIAL
    return crc


def _stuffed(content: list[int]) -> list[int]:
    levels: list[int] = []
    run, last = 0, None
    for bit in content:
        run = run + 1 if bit == last else 1
        last = bit
        levels.append(bit)
        if run == LONGEST_RUN:
            last = 1 - bit
            levels.append(last)
            run = 1
    return levels
