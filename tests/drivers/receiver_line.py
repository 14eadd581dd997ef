"""A wire into a ReceiverStream: circular DMA with its half, full and idle-line calls, at exact times."""

import functools
import operator
from collections.abc import Iterable

from firmware.drivers import receiver_state as st
from firmware.drivers.gnss_epoch import as_dict
from firmware.drivers.receiver_stream import ReceiverStream


def sentence(body: str) -> bytes:
    """`$body*hh` and CR LF; the checksum is the XOR of all characters of the body."""
    check = functools.reduce(operator.xor, body.encode("latin-1"), 0)
    return f"${body}*{check:02X}\r\n".encode("latin-1")


class ReceiverLine:
    """Plays bytes into the stream and collects its epochs as dictionaries."""

    def __init__(self, stream: ReceiverStream | None = None) -> None:
        self.stream = stream or ReceiverStream()
        self.byte_ns = int(self.stream.state[st.BYTE_NS])
        self.received = 0
        self.time_ns = 0
        self.epochs: list[dict[str, int]] = []

    def send(self, data: bytes, start_ns: int | None = None) -> None:
        """Bytes one after the other from `start_ns` (default: at once), then an idle line."""
        if start_ns is not None:
            self.time_ns = start_ns
        ring = self.stream.ring
        half = len(ring) // 2
        for byte in data:
            ring[self.received % len(ring)] = byte
            self.received += 1
            self.time_ns += self.byte_ns
            if self.received % half == 0:
                self._interrupt(self.time_ns)
        self._interrupt(self.time_ns + (self.byte_ns if self.received % half else 0))

    def chunks(self, pieces: Iterable[bytes]) -> None:
        """Bytes one after the other without a pause, the parser called after each piece."""
        ring = self.stream.ring
        for piece in pieces:
            for byte in piece:
                ring[self.received % len(ring)] = byte
                self.received += 1
            self.time_ns += len(piece) * self.byte_ns
            idle = self.byte_ns if self.received % (len(ring) // 2) else 0
            self._interrupt(self.time_ns + idle)

    def silence(self, duration_ns: int = 100_000_000) -> None:
        """Nothing for a while, then a look at the line."""
        self.time_ns += duration_ns
        self._interrupt(self.time_ns)

    def _interrupt(self, now_ns: int) -> None:
        while self.stream.take(self.received, now_ns):
            self.epochs.append(as_dict(self.stream.epoch))


def epochs_of(data: bytes) -> list[dict[str, int]]:
    """All epochs of one burst."""
    line = ReceiverLine()
    line.send(data)
    line.silence()
    return line.epochs


def epoch_of(*bodies: str) -> dict[str, int]:
    """The only epoch of the sentences with these bodies."""
    (epoch,) = epochs_of(b"".join(sentence(body) for body in bodies))
    return epoch
