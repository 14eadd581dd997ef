"""Packets between two processors on virtual time.

A transfer takes its words' bits at the clock, and a pause after each but the last. The receiver has them all
when it ends; the processors take no part in it. A reset of the sender breaks the transfer off: the words that
were whole have come. A reset of the receiver ends reception.
"""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct
from typing import Final

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import EmulatedLine, emulated_line
from hal.emulated.virtual_time import SECOND, Event
from hal.interrupts import InterruptLine

WORD_BYTES: Final = 2
Disturbance = Callable[[bytes], bytes]


class EmulatedPacketReceiver:
    """Implements `hal.packet_link.PacketReceiver`."""

    def __init__(self, name: str, cpu: EmulatedCpu) -> None:
        self.name = name
        self.busy_ns = 0
        self.transactions = 0
        """Transfers that ended while it received."""
        self.bytes = 0
        """What its DMA has written to memory."""
        self._ring = bytearray()
        self._whole = Struct("")
        """Puts a transfer into the ring in half the time of an assignment to its slice."""
        self._packet_bytes = 0
        self._line: EmulatedLine | None = None
        self._count = 0
        self._begun_ns = 0
        self._cpu = cpu
        cpu.reset_hooks.append(self._reset)

    def begin(self, ring: bytearray, packet_bytes: int, line: InterruptLine) -> None:
        """See `hal.packet_link.PacketReceiver`."""
        if packet_bytes <= 0 or packet_bytes % WORD_BYTES or not ring or len(ring) % packet_bytes:
            raise ValueError(
                f"packet link {self.name!r}: a ring of {len(ring)} bytes for packets of {packet_bytes};"
                " it holds whole packets of whole words, e.g. 192 bytes for packets of 96"
            )
        self._ring, self._packet_bytes = ring, packet_bytes
        self._count = 0
        self._begun_ns = self._cpu.time.now
        self._line = emulated_line(line)

    def received(self) -> int:
        """See `hal.packet_link.PacketReceiver`."""
        return self._count

    def take(self, data: bytes, start_ns: int, end_ns: int) -> None:
        """A transfer that began and ended then has brought `data`."""
        line = self._line
        if line is None or start_ns < self._begun_ns:
            return
        self.transactions += 1
        self.bytes += len(data)
        self.busy_ns += end_ns - start_ns
        ring, count, size = self._ring, self._count, len(self._ring)
        place, length = count % size, len(data)
        if place + length <= size:
            if length != self._whole.size:
                self._whole = Struct(f"{length}s")
            self._whole.pack_into(ring, place, data)
        else:
            for byte in data:
                ring[place] = byte
                place = (place + 1) % size
        self._count = count + length
        if self._count // self._packet_bytes != count // self._packet_bytes:
            line.request()

    def _reset(self) -> None:
        self._line = None


class EmulatedPacketSender:
    """Implements `hal.packet_link.PacketSender`."""

    def __init__(
        self, name: str, cpu: EmulatedCpu, receiver: EmulatedPacketReceiver, clock_hz: int, pause_ns: int = 0
    ) -> None:
        if clock_hz <= 0:
            raise ValueError(
                f"packet link {name!r}: clock of {clock_hz} Hz; it must be positive, e.g. 8_750_000"
            )
        self.name = name
        self.busy_ns = 0
        self.transactions = 0
        self.bytes = 0
        """What its DMA has read from memory."""
        self.refused = 0
        """Packets that found the one before under way."""
        self.disturbances: list[Disturbance] = []
        """Faults of the wire: each makes other bytes of those that are sent."""
        self.time = cpu.time
        """Virtual time that it works in."""
        self._receiver = receiver
        self._clock_hz = clock_hz
        self._pause_ns = pause_ns
        self._data = b""
        self._start_ns = self._end_ns = 0
        self._event: Event | None = None
        cpu.reset_hooks.append(self._reset)

    def duration_ns(self, length: int) -> int:
        """Of a transfer of `length` bytes."""
        return 8 * length * SECOND // self._clock_hz + (length // WORD_BYTES - 1) * self._pause_ns

    def send(self, data: bytes) -> bool:
        """See `hal.packet_link.PacketSender`."""
        if not data or len(data) % WORD_BYTES:
            raise ValueError(
                f"packet link {self.name!r}: {len(data)} bytes are no whole words of {WORD_BYTES} bytes"
            )
        now = self.time.now
        if self._event is not None:
            self.refused += 1
            return False
        self._data = bytes(data)
        self._start_ns = now
        self._end_ns = end = now + self.duration_ns(len(data))
        self.transactions += 1
        self._event = self.time.at(end, self._arrive)
        return True

    def _arrive(self) -> None:
        self._event = None
        self.busy_ns += self._end_ns - self._start_ns
        data = self._data
        self.bytes += len(data)
        for disturb in self.disturbances:
            data = disturb(data)
        if data:
            self._receiver.take(data, self._start_ns, self._end_ns)

    def _reset(self) -> None:
        event = self._event
        if event is None:
            return
        event.cancel()
        self._event = None
        now = self.time.now
        words = len(self._data) // WORD_BYTES
        done = words * (now - self._start_ns) // (self._end_ns - self._start_ns)
        self.busy_ns += now - self._start_ns
        self.bytes += WORD_BYTES * done
        if done:
            self._receiver.take(self._data[: WORD_BYTES * done], self._start_ns, now)
