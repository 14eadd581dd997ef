"""The host's RS-232 line at the FPGA: pieces of output from the memory's ring, as the port has room.

After a reset of either processor both begin where the DSP's next word in the mailbox says.
"""

from __future__ import annotations

from firmware.apps.dual_antenna import memory_map as at
from hal.board_io import BoardIo


class HostLine:
    """Owns the port."""

    def __init__(self, io: BoardIo) -> None:
        self._memory = io.memories["exchange"]
        self._uart = io.uart["host"]
        self._cpu = io.cpu
        self._cost = io.cpu.cost("output_piece")
        self._line = io.interrupts.attach("host_output", self._on_ring)
        self._announced = self._taken = 0

    def begin(self) -> None:
        """Nothing of what was said before is sent."""
        self._announced = self._taken = self._memory.rung()
        self._tell()
        self._memory.interrupt_on_ring(self._line)

    def drain(self) -> None:
        """From the background: the port may have room again for what is left. What is new calls by itself."""
        if self._taken != self._announced and self._memory.rung() == self._announced:
            self._line.pend()

    def _on_ring(self) -> None:
        self._announced = self._memory.rung()
        before = self._taken
        while self._taken != self._announced and self._take_piece():
            self._cpu.spend(self._cost)
        if self._taken != before:
            self._tell()

    def _take_piece(self) -> bool:
        """The next piece to the port; False: it has no room for it."""
        waiting = (self._announced - self._taken) & at.WORD_MASK
        length = int.from_bytes(self._read(self._taken, 1), "little")
        words = at.words_of(length)
        if length > at.LONGEST_PIECE or words > waiting or waiting > at.OUTPUT_WORDS:
            self._taken = self._announced  # not a ring that both agree on: the DSP has begun anew
            return True
        if self._uart.tx_free() < length:
            return False
        if length:
            self._uart.write(self._read(self._taken + 1, words - 1)[:length])
        self._taken = (self._taken + words) & at.WORD_MASK
        return True

    def _read(self, word: int, count: int) -> bytes:
        """Words of the ring, which may go over its end."""
        place = word % at.OUTPUT_WORDS
        first = min(count, at.OUTPUT_WORDS - place)
        data = self._memory.read(at.OUTPUT_AT + place, first)
        return data if first == count else data + self._memory.read(at.OUTPUT_AT, count - first)

    def _tell(self) -> None:
        self._memory.write(at.TAKEN_AT, self._taken.to_bytes(at.WORD, "little"))
