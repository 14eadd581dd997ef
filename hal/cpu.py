"""The processor as its program sees it: work that takes time, and sleep until an interrupt."""

from typing import Protocol


class Cpu(Protocol):
    """One processor core.

    Emulated, `spend` moves virtual time on by the cycles the real core would need; interrupts of higher
    priority run meanwhile. Live, the host has already spent its own time, and `spend` returns at once.
    """

    def cost(self, work: str) -> int:
        """Cycles budgeted for a named piece of work in the board's table.

        Look a cost up once at set-up. Raises KeyError that lists the known names.
        """
        ...

    def spend(self, cycles: int) -> None:
        """Do `cycles` of work at the current priority."""
        ...

    def wait_for_interrupt(self) -> None:
        """Sleep until at least one interrupt handler has run (the WFI instruction)."""
        ...

    def delay(self, duration_ns: int) -> None:
        """Busy-wait for at least `duration_ns` (set-up code only; interrupts run meanwhile)."""
        ...
