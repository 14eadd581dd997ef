"""What a board's flash holds, looked at from outside: the firmware's own reader on an image of the memory."""

from __future__ import annotations

from boards.description import Board
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.corrections import Corrections

FLASH = "calibration"


class FlashImage:
    """Implements `hal.flash.FlashMemory`; nothing can be written."""

    def __init__(self, content: bytes, blocks: int, block_bytes: int) -> None:
        self.blocks = blocks
        self.block_bytes = block_bytes
        self._content = content

    def read(self, place: int, length: int) -> bytes:
        """From the image."""
        return self._content[place : place + length]

    def erase(self, block: int) -> bool:
        """Not here."""
        return False

    def program(self, place: int, data: bytes) -> bool:
        """Not here."""
        return False


def calibration_in(content: bytes, board: Board) -> Calibration:
    """What the firmware would load from it."""
    facts = board.flash[FLASH]
    found = Calibration(FlashImage(content, facts.blocks, facts.block_bytes), Corrections())
    found.load()
    return found
