"""What a writer has to know of what it writes."""

from __future__ import annotations

from typing import Protocol

from host.simulate.ambient import Ambient
from host.simulate.stream import Convention


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
    def ambients(self) -> tuple[Ambient, ...]:
        """Magnetometer and barometer, where there are."""
        ...

    @property
    def start_gps_ns(self) -> int:
        """GPS time of the start."""
        ...
