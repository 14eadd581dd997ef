"""General-purpose pins."""

from enum import Enum
from typing import Protocol

from hal.interrupts import InterruptLine


class Edge(Enum):
    """Which edge of an input makes an interrupt pending."""

    RISING = "rising"
    FALLING = "falling"
    BOTH = "both"


class OutputPin(Protocol):
    """A pin the firmware drives."""

    def set(self, level: bool) -> None:
        """Drive the electrical level."""
        ...


class InputPin(Protocol):
    """A pin the firmware reads."""

    def read(self) -> bool:
        """The electrical level now."""
        ...

    def interrupt_on(self, edge: Edge, line: InterruptLine) -> None:
        """Pend `line` at every such edge."""
        ...
