"""What a bus is to the drawing: lines with levels, and units of traffic that become edges on them.

A capture tells of transactions, pieces and frames with their beginnings and ends. A tracer turns each into
units (a period of chip select low, a byte on a serial line, a frame), and a unit into edges. Units of one
lane share lines and come one after the other; lanes of one bus (the directions of a UART) overlap freely.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from host.capture.blocks import Traffic

Level = int | str
"""0, 1, "z" (nobody drives the line) or "x" (not known)."""


class Edge(NamedTuple):
    """A line of a bus, by its place in `Tracer.lines`, takes a level."""

    time_ns: int
    line: int
    level: Level


class Unit(NamedTuple):
    """The smallest piece of traffic that is drawn as a whole. `content` None: what was told before of this
    lane and begins at `begin_ns` or later did not come."""

    begin_ns: int
    end_ns: int
    lane: int
    content: Any


class Tracer(Protocol):
    """One bus of a capture."""

    name: str
    kind: str
    lines: list[str]
    """Names, each of them unlike those of every other bus."""
    idle: list[Level]
    """Of each line."""
    lanes: list[list[int]]
    """Of each lane the lines that it draws on."""
    gap_ns: int
    """So much earlier a unit ends than it was recorded when the next one begins at its very end, so that
    the edges between them can be seen."""

    def units(self, record: Traffic) -> list[Unit]:
        """The units of one record; records come in the order of time."""
        ...

    def edges(self, unit: Unit) -> list[Edge]:
        """The edges of one unit in the order of time, from idle lines back to idle lines."""
        ...

    def facts(self) -> dict[str, Any]:
        """What the drawing took for granted: clock, mode, rates."""
        ...
