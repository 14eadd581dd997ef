"""Interrupt lines: hardware lines and software tasks share one priority scheme.

A line is named in the board description, which also gives its priority (lower number = more urgent),
deadline and stack. A handler runs to completion and is nested by more urgent lines only. A task of the
firmware is a line without hardware behind it, made ready by `pend`.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol


class InterruptLine(Protocol):
    """One line of the interrupt controller."""

    def pend(self) -> None:
        """Make the line pending; a line already pending stays so (the second request is an overrun)."""
        ...

    def enable(self) -> None:
        """Let the line interrupt the processor."""
        ...

    def disable(self) -> None:
        """Hold the line back; a request meanwhile stays pending."""
        ...


class LineFigures(NamedTuple):
    """What one line has done since power-on."""

    name: str
    activations: int
    busy_ns: int
    """Time in its handler, more urgent lines left out."""
    worst_response_ns: int
    """From the request to the end of the handler."""
    deadlines_missed: int


class InterruptController(Protocol):
    """Hands out the lines that the board description names."""

    def attach(self, name: str, handler: Callable[[], None]) -> InterruptLine:
        """Install `handler` on the line `name`, enable it and return it.

        Raises KeyError that lists the known names when the board has no such line.
        """
        ...

    def figures(self) -> list[LineFigures]:
        """Figures of the lines that have run, in any order."""
        ...
