"""A scripted side of a dual-port memory."""

from __future__ import annotations

from hal.interrupts import InterruptLine
from hal.scripted.transcript import Transcript, hex_words, to_bytes


class ScriptedDualPort:
    """Implements `hal.dual_port.DualPortMemory`: `memory NAME read ADDRESS N -> BYTES`,
    `memory NAME write ADDRESS BYTES`, `memory NAME ring VALUE`, `<- memory NAME ring VALUE`."""

    def __init__(self, transcript: Transcript, name: str, words: int, word_bytes: int = 4) -> None:
        self.name = name
        self.words = words
        self.word_bytes = word_bytes
        self._transcript = transcript
        self._mailbox = 0
        self._line: InterruptLine | None = None
        transcript.on_arrival("memory", name, self._take_ring)

    def read(self, address: int, count: int) -> bytes:
        """A step."""
        self._check(address, count)
        data = to_bytes(self._transcript.take(f"memory {self.name} read {address} {count}"))
        if len(data) != count * self.word_bytes:
            raise ValueError(
                f"the transcript answers {len(data)} bytes to {count} words of memory {self.name!r};"
                f" they have {self.word_bytes} each, e.g. 'memory emif read 0 1 -> 01 00 00 00'"
            )
        return data

    def write(self, address: int, data: bytes) -> None:
        """A step."""
        count, rest = divmod(len(data), self.word_bytes)
        if rest:
            raise ValueError(f"{len(data)} bytes are no whole words of {self.word_bytes} bytes")
        self._check(address, count)
        self._transcript.take(f"memory {self.name} write {address} {hex_words(data)}")

    def ring(self, value: int) -> None:
        """A step."""
        self._transcript.take(f"memory {self.name} ring {value}")

    def rung(self) -> int:
        """The word in the mailbox."""
        self._transcript.play()
        return self._mailbox

    def interrupt_on_ring(self, line: InterruptLine) -> None:
        """Pend `line` at each ring."""
        self._line = line

    def _take_ring(self, words: list[str]) -> None:
        if len(words) != 2 or words[0] != "ring" or not words[1].isdecimal():
            raise ValueError(
                f"{' '.join(words)!r} comes in at memory {self.name!r}; for example '<- memory emif ring 5'"
            )
        self._mailbox = int(words[1])
        if self._line is not None:
            self._line.pend()

    def _check(self, address: int, count: int) -> None:
        if address < 0 or count < 1 or address + count > self.words:
            raise ValueError(
                f"memory {self.name!r}: words {address} … {address + count - 1}; it has 0 … {self.words - 1}"
            )
