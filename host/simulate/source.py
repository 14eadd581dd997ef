"""What a writer has to know of what it writes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from host.record.tables import Table
from host.simulate.convention import Convention


@dataclass(frozen=True, slots=True)
class SideTable:
    """Rows that are written as a file, member or topic of their own, called `name`."""

    name: str
    table: Table


class Source(Protocol):
    """A drive, simulated or inverted."""

    @property
    def convention(self) -> Convention:
        """What a sample stands for."""
        ...

    @property
    def samples(self) -> int:
        """How many there will be."""
        ...

    @property
    def epochs(self) -> int:
        """How many of a receiver."""
        ...

    @property
    def side_tables(self) -> tuple[SideTable, ...]:
        """What comes at rates of its own: magnetometer, barometer, baseline, where there are."""
        ...

    @property
    def start_gps_ns(self) -> int:
        """GPS time of the start."""
        ...
