"""A scripted I²C slave."""

from __future__ import annotations

from hal.interrupts import InterruptLine
from hal.scripted.transcript import Transcript, hex_words, to_bytes


class ScriptedI2cSlave:
    """Implements `hal.i2c_slave.I2cSlavePort`: `slave NAME answer BYTES`, `<- slave NAME BYTES`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self.name = name
        self._transcript = transcript
        self._line: InterruptLine | None = None
        self._written = b""
        transcript.on_arrival("slave", name, self._arrive)

    def begin(self, line: InterruptLine) -> None:
        """Writes may come from now on."""
        self._line = line
        self._written = b""

    def taken(self) -> bytes:
        """What the master wrote last, once."""
        self._transcript.play()
        data, self._written = self._written, b""
        return data

    def answer(self, data: bytes) -> None:
        """A step."""
        self._transcript.take(f"slave {self.name} answer {hex_words(data)}")

    def _arrive(self, words: list[str]) -> None:
        if self._line is not None and not self._written:
            self._written = to_bytes(tuple(words))
            self._line.pend()
