"""Non-volatile memory of a processor: flash in blocks, for a few settings.

    erase      a whole block to 0xFF
    program    bits of erased bytes to 0; takes pages one after the other
    read       at any time

A power cut during `erase` or `program` leaves the block or page half done: who wants more keeps two copies
with check sums and writes them in turn.
"""

from typing import Protocol


class FlashMemory(Protocol):
    """One memory. Places and blocks beyond its end raise ValueError."""

    blocks: int
    block_bytes: int

    def read(self, place: int, length: int) -> bytes:
        """`length` bytes from `place` on."""
        ...

    def erase(self, block: int) -> bool:
        """All of a block 0xFF; False: the memory did not do it."""
        ...

    def program(self, place: int, data: bytes) -> bool:
        """`data` from `place` on, within one block: what is there AND data; False: it did not do it."""
        ...
