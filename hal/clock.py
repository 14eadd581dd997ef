"""The processor's own free-running time base."""

from typing import Protocol


class Clock(Protocol):
    """Time since the processor left reset.

    On a real board this is a free-running timer fed by the crystal, so it runs fast or slow with it.
    """

    def now_ns(self) -> int:
        """Time since reset in nanoseconds of this processor's own crystal; never goes backwards."""
        ...
