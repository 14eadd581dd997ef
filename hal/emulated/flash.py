"""Flash on virtual time, with times like those of the XC3S400AN's own (4 ms a page, 13 ms an erasure).

A page is half programmed, and a block half erased, in the middle of its time: whoever cuts the power or
resets the processor then finds it so.
"""

from __future__ import annotations

from dataclasses import dataclass

from hal.emulated.cpu import EmulatedCpu

CLEAR = 0xFF


@dataclass(frozen=True)
class FlashTiming:
    """How long it takes."""

    page_bytes: int = 264
    program_ns: int = 4_000_000
    """Of a page, or a part of one."""
    erase_ns: int = 13_000_000
    """Of a block."""


class EmulatedFlash:
    """Implements `hal.flash.FlashMemory`."""

    def __init__(
        self,
        cpu: EmulatedCpu,
        name: str,
        blocks: int = 2,
        block_bytes: int = 2112,
        timing: FlashTiming | None = None,
    ) -> None:
        if blocks < 1 or block_bytes < 1:
            raise ValueError(
                f"flash {name!r}: {blocks} blocks of {block_bytes} bytes;"
                " both must be positive, like 2 of 2112"
            )
        self.name = name
        self.blocks = blocks
        self.block_bytes = block_bytes
        self.timing = timing or FlashTiming()
        self.failed = False
        """A memory that is worn out: it changes nothing any more."""
        self.programs = 0
        self.erasures = 0
        self._cpu = cpu
        self._cells = bytearray((CLEAR,)) * (blocks * block_bytes)

    @property
    def content(self) -> bytes:
        """All of it, as a power cut at this moment would leave it."""
        return bytes(self._cells)

    def load(self, content: bytes) -> None:
        """What it held when the board was last switched off. Raises ValueError for another length."""
        if len(content) != len(self._cells):
            raise ValueError(f"{len(content)} bytes; flash {self.name!r} has {len(self._cells)}")
        self._cells[:] = content

    def read(self, place: int, length: int) -> bytes:
        """See `hal.flash.FlashMemory`."""
        self._check(place, length)
        return bytes(self._cells[place : place + length])

    def erase(self, block: int) -> bool:
        """See `hal.flash.FlashMemory`."""
        start, size = block * self.block_bytes, self.block_bytes
        self._check(start, size)
        self._pass(self.timing.erase_ns // 2)
        if self.failed:
            return False
        self.erasures += 1
        self._cells[start : start + size // 2] = bytes((CLEAR,)) * (size // 2)
        self._pass(self.timing.erase_ns // 2)
        self._cells[start : start + size] = bytes((CLEAR,)) * size
        return True

    def program(self, place: int, data: bytes) -> bool:
        """See `hal.flash.FlashMemory`."""
        self._check(place, len(data))
        if data and place // self.block_bytes != (place + len(data) - 1) // self.block_bytes:
            raise ValueError(
                f"flash {self.name!r}: {len(data)} bytes from {place} on go over the end of a block of"
                f" {self.block_bytes}"
            )
        done = 0
        while done < len(data):
            count = self.timing.page_bytes - (place + done) % self.timing.page_bytes
            if not self._program_page(place + done, data[done : done + count]):
                return False
            done += count
        return True

    def _program_page(self, place: int, data: bytes) -> bool:
        half = len(data) // 2
        self._pass(self.timing.program_ns // 2)
        if self.failed:
            return False
        self.programs += 1
        self._clear_bits(place, data[:half])
        self._pass(self.timing.program_ns // 2)
        self._clear_bits(place + half, data[half:])
        return True

    def _clear_bits(self, place: int, data: bytes) -> None:
        for k, byte in enumerate(data, place):
            self._cells[k] &= byte

    def _pass(self, duration_ns: int) -> None:
        self._cpu.wait_until(self._cpu.time.now + duration_ns)

    def _check(self, place: int, length: int) -> None:
        if place < 0 or length < 0 or place + length > len(self._cells):
            raise ValueError(
                f"flash {self.name!r}: {length} bytes from {place} on; it has the places 0 …"
                f" {len(self._cells) - 1}"
            )
