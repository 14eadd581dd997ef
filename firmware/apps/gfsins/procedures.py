"""Calibration in settings mode, one procedure at a time: the FPGA collects, the DSP solves.

    start(name)   WAITING: the table is to be brought into the position that `prompt` tells
    take()        it stands there: COLLECTING, then WAITING for the next, after the last SOLVING
    abandon()     IDLE again
    DONE          result_lines; the coefficients are stored
    FAILED        result_lines tell why; take() tries again

`tick` belongs into the timer interrupt of 200 Hz, `service` into the background, ten times a second.
"""

from __future__ import annotations

from enum import Enum

from hal.board_io import BoardIo

NAMES = ("accelerometers", "rates", "earth-rate", "compass", "ellipse", "alignment")
LINE = 21
"""Characters of a line of the screen."""


class State(Enum):
    """Where a procedure is."""

    IDLE = "idle"
    WAITING = "waiting"
    COLLECTING = "collecting"
    SOLVING = "solving"
    DONE = "done"
    FAILED = "failed"


class Procedures:
    """What the menu sees."""

    NAMES = NAMES

    def __init__(self, io: BoardIo) -> None:
        self.state = State.IDLE
        self.prompt = ""
        """At most LINE characters."""
        self.position = 0
        """The one that is waited for or collected, from 0."""
        self.positions = 0
        self.progress = 0.0
        """Of all, 0 to 1."""
        self.result_lines: list[str] = []
        """Each at most LINE characters."""
        self._io = io

    def begin(self) -> None:
        """From main, once: the sensors are brought up."""

    def tick(self) -> None:
        """From the timer interrupt, 200 times a second."""

    def service(self) -> None:
        """From the background."""

    def start(self, name: str) -> bool:
        """Begin a procedure; False: there is none of that name, or one is running."""
        if name not in NAMES or self.state in (State.WAITING, State.COLLECTING, State.SOLVING):
            return False
        self.state = State.WAITING
        return True

    def take(self) -> bool:
        """The operator says that the table stands as it should; False: nobody waits for it."""
        return False

    def abandon(self) -> None:
        """Whatever is running ends, nothing is stored."""
        self.state = State.IDLE
