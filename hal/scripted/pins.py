"""Scripted pins."""

from __future__ import annotations

from hal.interrupts import InterruptLine
from hal.pins import Edge
from hal.scripted.transcript import Transcript

LEVELS = {"high": True, "low": False}


class ScriptedOutput:
    """Implements `hal.pins.OutputPin`: `pin NAME high|low` for every call."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name

    def set(self, level: bool) -> None:
        """A step."""
        self._transcript.take(f"pin {self.name} {'high' if level else 'low'}")


class ScriptedInput:
    """Implements `hal.pins.InputPin`: `<- pin NAME high|low`; low at first."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name
        self._level = False
        self._edge: Edge | None = None
        self._line: InterruptLine | None = None
        transcript.on_arrival("pin", name, self._change)

    def read(self) -> bool:
        """The level now."""
        self._transcript.play()
        return self._level

    def interrupt_on(self, edge: Edge, line: InterruptLine) -> None:
        """Pend `line` at every such edge."""
        self._edge = edge
        self._line = line

    def _change(self, words: list[str]) -> None:
        level = LEVELS[words[0]]
        if level == self._level:
            return
        self._level = level
        wanted = self._edge is Edge.BOTH or self._edge is (Edge.RISING if level else Edge.FALLING)
        if wanted and self._line is not None:
            self._line.pend()
