"""Scripted timers."""

from __future__ import annotations

from hal.interrupts import InterruptLine
from hal.scripted.transcript import Transcript


class ScriptedTimer:
    """Implements `hal.timers.PeriodicTimer`: `timer NAME start RATE`, `timer NAME stop`, `<- timer NAME`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name
        self._line: InterruptLine | None = None
        transcript.on_arrival("timer", name, self._expire)

    def start(self, rate_hz: int, line: InterruptLine) -> None:
        """A step."""
        self._transcript.take(f"timer {self.name} start {rate_hz}")
        self._line = line

    def stop(self) -> None:
        """A step."""
        self._transcript.take(f"timer {self.name} stop")
        self._line = None

    def _expire(self, _words: list[str]) -> None:
        assert self._line is not None, f"timer {self.name!r} expires in the transcript, but was not started"
        self._line.pend()


class ScriptedCapture:
    """Implements `hal.timers.CaptureTimer`: `capture NAME start`, `<- capture NAME CLOCK_NS`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name
        self._line: InterruptLine | None = None
        self._edges = 0
        self._last_ns = 0
        transcript.on_arrival("capture", name, self._capture)

    def start(self, line: InterruptLine | None = None) -> None:
        """A step."""
        self._transcript.take(f"capture {self.name} start")
        self._line = line
        self._edges = self._last_ns = 0

    def captured(self) -> tuple[int, int]:
        """(edges since `start`, clock at the last one)."""
        self._transcript.play()
        return self._edges, self._last_ns

    def _capture(self, words: list[str]) -> None:
        self._edges += 1
        self._last_ns = int(words[0])
        if self._line is not None:
            self._line.pend()
