"""A scripted UART."""

from __future__ import annotations

from hal.interrupts import InterruptLine
from hal.scripted.transcript import Transcript, hex_words, to_bytes

QUEUE_BYTES = 1024


class ScriptedUart:
    """Implements `hal.uart.Uart`: `uart NAME write BYTES`, `uart NAME baud RATE`, `<- uart NAME BYTES`.

    The transmit queue is always empty, so that `tx_free` answers `QUEUE_BYTES`.
    """

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name
        self.baud = 9600
        """As after power-on; no step."""
        self._ring = bytearray()
        self._line: InterruptLine | None = None
        self._received = 0
        self._errors = 0

    def set_baud(self, baud: int) -> None:
        """A step."""
        self._transcript.take(f"uart {self.name} baud {baud}")
        self.baud = baud

    def write(self, data: bytes) -> int:
        """A step; nothing to write is none."""
        if not data:
            return 0
        reply = self._transcript.take(f"uart {self.name} write {hex_words(data)}")
        return int(reply[0]) if reply else len(data)

    def tx_free(self) -> int:
        """Room left in the transmit queue."""
        return QUEUE_BYTES

    def start_receive(self, ring: bytearray, line: InterruptLine) -> None:
        """Bytes may come in from now on."""
        if not ring:
            raise ValueError("the receive ring is empty; give a bytearray with room, e.g. bytearray(512)")
        self._ring = ring
        self._line = line
        self._received = 0
        self._transcript.on_arrival("uart", self.name, self._arrive)

    def received(self) -> int:
        """Bytes put into the ring since `start_receive`."""
        self._transcript.play()
        return self._received

    def take_errors(self) -> int:
        """Errors since the last call."""
        self._transcript.play()
        errors, self._errors = self._errors, 0
        return errors

    def _arrive(self, words: list[str]) -> None:
        if words[0] == "errors":
            self._errors += int(words[1])
            return
        for byte in to_bytes(words):
            self._ring[self._received % len(self._ring)] = byte
            self._received += 1
        assert self._line is not None
        self._line.pend()
