"""What the FPGA hands to the DSP: records into the memory's rings, and word of them."""

from __future__ import annotations

from firmware.apps.dual_antenna import memory_map as at
from hal.board_io import BoardIo


class Post:
    """Tells the DSP what has come."""

    def __init__(self, io: BoardIo, starts: int) -> None:
        self.starts = starts & at.WORD_MASK
        self._memory = io.memories["exchange"]
        self._samples = 0
        self._epochs = 0
        self._word = (self.starts & at.BYTE) << at.START_SHIFT
        """For the mailbox, all but the samples."""

    def sample(self, record: bytes) -> None:
        """A sample into the ring, and word of it."""
        samples, memory = self._samples, self._memory
        memory.write(samples % at.SAMPLES * at.SAMPLE_WORDS, record)
        self._samples = samples = samples + 1 & at.COUNT_MASK
        memory.ring(self._word | samples)

    def epoch(self, record: bytes) -> None:
        """An epoch likewise."""
        slot = self._epochs % at.EPOCHS
        self._memory.write(at.EPOCHS_AT + slot * at.EPOCH_WORDS, record)
        self._epochs = self._epochs + 1 & at.BYTE
        starts = (self.starts & at.BYTE) << at.START_SHIFT
        self._word = starts | self._epochs << at.EPOCH_SHIFT
        self._memory.ring(self._word | self._samples)
