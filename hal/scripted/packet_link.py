"""Scripted ends of a packet link."""

from __future__ import annotations

from hal.interrupts import InterruptLine
from hal.scripted.transcript import Transcript, hex_words, to_bytes

WORD_BYTES = 2


class ScriptedPacketSender:
    """Implements `hal.packet_link.PacketSender`: `packets NAME send BYTES`, replied to by nothing or
    `busy`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self.name = name
        self._transcript = transcript

    def send(self, data: bytes) -> bool:
        """A step."""
        if not data or len(data) % WORD_BYTES:
            raise ValueError(f"{len(data)} bytes are no whole words of {WORD_BYTES} bytes")
        reply = self._transcript.take(f"packets {self.name} send {hex_words(data)}")
        return tuple(reply) != ("busy",)


class ScriptedPacketReceiver:
    """Implements `hal.packet_link.PacketReceiver`: `<- packets NAME BYTES`, whole words."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self.name = name
        self._transcript = transcript
        self._ring = bytearray()
        self._packet_bytes = 0
        self._line: InterruptLine | None = None
        self._count = 0
        transcript.on_arrival("packets", name, self._arrive)

    def begin(self, ring: bytearray, packet_bytes: int, line: InterruptLine) -> None:
        """Packets may come in from now on."""
        if packet_bytes <= 0 or packet_bytes % WORD_BYTES or not ring or len(ring) % packet_bytes:
            raise ValueError(f"a ring of {len(ring)} bytes for packets of {packet_bytes}; e.g. 192 and 96")
        self._ring, self._packet_bytes, self._line = ring, packet_bytes, line
        self._count = 0

    def received(self) -> int:
        """Bytes put into the ring since `begin`."""
        self._transcript.play()
        return self._count

    def _arrive(self, words: list[str]) -> None:
        data = to_bytes(tuple(words))
        if len(data) % WORD_BYTES:
            raise ValueError(f"{len(data)} bytes come in at packets {self.name!r}; words have {WORD_BYTES}")
        if self._line is None:
            return
        for byte in data:
            self._ring[self._count % len(self._ring)] = byte
            self._count += 1
        if self._count // self._packet_bytes != (self._count - len(data)) // self._packet_bytes:
            self._line.pend()
