"""When a receiver has no signal, and what the scenario makes it report wrongly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from host.sim.gnss.jamming import Jamming

NS = 1_000_000_000


@dataclass(frozen=True)
class Window:
    """A stretch of virtual time, end excluded."""

    start_ns: int
    end_ns: int

    def holds(self, time_ns: int) -> bool:
        """Whether an instant lies in it."""
        return self.start_ns <= time_ns < self.end_ns


def held(windows: Sequence[Window], time_ns: int) -> bool:
    """Whether an instant lies in one of the windows."""
    return any(window.holds(time_ns) for window in windows)


@dataclass
class Glitch:
    """A receiver fault: from `window` start to end what it reports is wrong, or its signals are weak."""

    name: str
    window: Window
    time_offset_ns: int = 0
    offset_ned_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pull_ned_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Reported velocity is off by this, and the position by what it makes since the start."""
    jamming: Jamming | None = None
    baseline_lost: bool = False
    """The second antenna is cut off."""
    baseline_turn: tuple[float, float] = (0.0, 0.0)
    """Reported heading and pitch of the baseline are off by this, rad."""
    baseline_stretch_m: float = 0.0
    """Its reported length is."""
    fired: int = field(default=0)
    """Epochs that came out wrong."""


def window(start_s: float, duration_s: float) -> Window:
    """From seconds."""
    start_ns = round(start_s * NS)
    return Window(start_ns, start_ns + round(duration_s * NS))
