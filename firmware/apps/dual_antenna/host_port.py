"""The way to the host from the DSP: pieces into the ring of output, and word of it to the FPGA."""

from __future__ import annotations

from firmware.apps.dual_antenna import memory_map as at
from hal.dual_port import DualPortMemory


class HostPort:
    """Implements `firmware.apps.gnss_ins.parts.HostPort`."""

    def __init__(self, memory: DualPortMemory) -> None:
        self._memory = memory
        self._said = self._taken()

    def begin(self) -> None:
        """The FPGA is to forget what it still has of before."""
        self._memory.ring(self._said)

    def tx_free(self) -> int:
        """Room for one piece, in bytes."""
        free = at.OUTPUT_WORDS - ((self._said - self._taken()) & at.WORD_MASK)
        return min(max(free - 1, 0) * at.WORD, at.LONGEST_PIECE)

    def write(self, data: bytes) -> int:
        """Queue all, or nothing."""
        if not data or self.tx_free() < len(data):
            return 0
        words = at.words_of(len(data))
        padded = len(data).to_bytes(at.WORD, "little") + data.ljust((words - 1) * at.WORD, b"\0")
        place = self._said % at.OUTPUT_WORDS
        first = min(words, at.OUTPUT_WORDS - place) * at.WORD
        self._memory.write(at.OUTPUT_AT + place, padded[:first])
        if first < len(padded):
            self._memory.write(at.OUTPUT_AT, padded[first:])
        self._said = (self._said + words) & at.WORD_MASK
        self._memory.ring(self._said)
        return len(data)

    def _taken(self) -> int:
        return int.from_bytes(self._memory.read(at.TAKEN_AT, 1), "little")
