"""Dual-port memory: words that two processors share, and a mailbox each way that interrupts the other.

    this side ──address, data──►  ┌─────────────────┐  ◄──address, data── other side
    (EMIF, or the bus of a        │ words 0 … n − 1 │      with its own access time
     block RAM)                   ├─────────────────┤
    ring(value) ─────────────────►│ mailbox         │──────────► interrupt there
    interrupt here ◄──────────────│ mailbox         │◄───────── ring(value)
                                  └─────────────────┘

An access of w words takes w access times of its side; the other side may access the memory meanwhile, and
nothing arbitrates. A word is written at the end of its own access time and read at the end of its own: who
reads what is being written finds new words before old ones. Firmware keeps them apart by the mailboxes.

Words are little endian; their width stands in the board description.
"""

from typing import Protocol

from hal.interrupts import InterruptLine


class DualPortMemory(Protocol):
    """One side of the memory."""

    @property
    def words(self) -> int:
        """How many there are."""
        ...

    @property
    def word_bytes(self) -> int:
        """How wide they are."""
        ...

    def read(self, address: int, count: int) -> bytes:
        """`count` words from word `address` on. Raises ValueError outside the memory."""
        ...

    def write(self, address: int, data: bytes) -> None:
        """Whole words from word `address` on. Raises ValueError outside the memory and for parts of words."""
        ...

    def ring(self, value: int) -> None:
        """Put a word into the other side's mailbox and interrupt it; what it has not read yet is lost."""
        ...

    def rung(self) -> int:
        """The word in this side's mailbox; 0 before the first."""
        ...

    def interrupt_on_ring(self, line: InterruptLine) -> None:
        """Pend `line` whenever the other side rings, from now on."""
        ...
