"""A scripted flash memory."""

from __future__ import annotations

from hal.scripted.transcript import Transcript, hex_words, to_bytes


class ScriptedFlash:
    """Implements `hal.flash.FlashMemory`: `flash NAME read PLACE N -> BYTES`,
    `flash NAME erase BLOCK [-> failed]`, `flash NAME program PLACE BYTES [-> failed]`."""

    def __init__(self, transcript: Transcript, name: str, blocks: int = 2, block_bytes: int = 2112) -> None:
        self._transcript = transcript
        self.name = name
        self.blocks = blocks
        self.block_bytes = block_bytes

    def read(self, place: int, length: int) -> bytes:
        """A step; nothing to read is none."""
        self._check(place, length)
        if not length:
            return b""
        data = to_bytes(self._transcript.take(f"flash {self.name} read {place} {length}"))
        if len(data) != length:
            raise ValueError(f"the transcript answers {len(data)} bytes to {length} of flash {self.name!r}")
        return data

    def erase(self, block: int) -> bool:
        """A step."""
        self._check(block * self.block_bytes, self.block_bytes)
        return self._transcript.take(f"flash {self.name} erase {block}") != ("failed",)

    def program(self, place: int, data: bytes) -> bool:
        """A step; nothing to program is none."""
        self._check(place, len(data))
        if data and place // self.block_bytes != (place + len(data) - 1) // self.block_bytes:
            raise ValueError(f"flash {self.name!r}: {len(data)} bytes from {place} on leave their block")
        step = f"flash {self.name} program {place} {hex_words(data)}"
        return not data or self._transcript.take(step) != ("failed",)

    def _check(self, place: int, length: int) -> None:
        if place < 0 or length < 0 or place + length > self.blocks * self.block_bytes:
            raise ValueError(f"flash {self.name!r} has no {length} bytes from {place} on")
