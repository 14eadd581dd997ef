"""A sensor on the desk, behind a serial bridge, under the driver that is flashed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray


class Quantity(NamedTuple):
    """One column of the samples as people read it: SI value times `factor`."""

    name: str
    unit: str
    factor: float = 1.0


class Found(NamedTuple):
    """What a look at the chip found, in words that show what was read."""

    ok: bool
    text: str
    absent: bool = False


@dataclass(slots=True)
class Poll:
    """What one poll brought."""

    samples: list[NDArray[np.float32]] = field(default_factory=list)
    """In SI units, one value for each quantity."""
    missed: int = 0
    """Samples that the chip made and nobody read, as far as it tells."""
    alive: bool = True
    """False: the bus reads as if nobody were there."""


class ChipOnDesk(Protocol):
    """One chip with its driver."""

    name: str
    quantities: tuple[Quantity, ...]
    polls_per_s: float
    """How often to poll so that no sample is missed."""

    def start(self) -> Found:
        """Identify and set up."""
        ...

    def check(self) -> Found:
        """Still there and as it was set up?"""
        ...

    def poll(self) -> Poll:
        """What is new."""
        ...

    def temperature(self) -> float | None:
        """°C; None when the chip does not tell."""
        ...

    def clock_s(self) -> float | None:
        """The chip's own time since its first sample; None when it does not tell."""
        ...
