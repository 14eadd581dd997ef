"""The bytes to and from one client, whatever carries them, without ever blocking.

A client that does not keep up: at a pace its buffer fills; from then on nothing more is put in until it is
empty again, so that a stalled client misses one contiguous piece, which is counted and told. Without a pace
the buffer never fills, because the run waits (`Terms.lossless`); a client that takes nothing for `stall_s`
is then cut off.
"""

from __future__ import annotations

import time
from typing import Protocol

from host.serve.endpoint import Terms, Traffic
from host.serve.hub import Hub, Waited

BUFFER_BYTES = 1 << 18
"""For a client that does not keep up: some 11 s of a line at 230,400 baud."""
MOST_BYTES = 1 << 20
INPUT_BYTES = 1 << 16
LONGEST_STEP_S = 0.1
READ_BYTES = 1 << 14


class Carrier(Protocol):
    """What carries the bytes: a socket or a pseudo-terminal, set not to block."""

    waited: Waited

    def read(self) -> bytes:
        """What has come; b"": the client has gone. Raises BlockingIOError, or OSError for a client gone."""
        ...

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Hand over; how much was taken. Raises as `read`."""
        ...

    def close(self, gently: bool) -> None:
        """End the connection; gently: let the client have first what it was given."""
        ...


class Stream:
    """One client's two directions. `gone` is set when it has left or was cut off."""

    def __init__(
        self,
        hub: Hub,
        carrier: Carrier,
        name: str,
        terms: Terms,
        traffic: Traffic,
        answers_to_the_end: bool = False,
    ) -> None:
        """`answers_to_the_end`: a client that has said all it wants to say still listens; whoever answers it
        closes the stream."""
        self.name = name
        self.gone = False
        self.said_all = False
        """It will send nothing more."""
        self.cut_off = False
        """It did not go by itself."""
        self.lost = 0
        self._hub = hub
        self._carrier = carrier
        self._terms = terms
        self._traffic = traffic
        self._answers_to_the_end = answers_to_the_end
        self._out = bytearray()
        self._in = bytearray()
        self._full = False
        self._waited_s = 0.0
        """For so long the client has taken nothing of what waits."""
        self._attended_s = time.monotonic()
        self._watch()

    # -- to the client -----------------------------------------------------------------------------

    def send(self, data: bytes) -> None:
        """Hand over, or keep for later; in one piece or not at all."""
        if self.gone or not data:
            return
        if not self._terms.lossless and (self._full or len(self._out) + len(data) > BUFFER_BYTES):
            self._lose(len(data))
            return
        waited = bool(self._out)
        self._out += data
        if not waited:
            self._waited_s = 0.0
            self._write()

    def send_aside(self, data: bytes) -> None:
        """Hand over what is not of the line (answers of a protocol): always, unless it is never read."""
        if not self.gone and len(self._out) > MOST_BYTES:
            self._leave("asks and never reads the answers; it was cut off")
        elif not self.gone:
            self._out += data
            self._write()

    @property
    def backlog(self) -> int:
        """Bytes that the client has not taken yet."""
        return len(self._out)

    def attend(self) -> None:
        """Cut the client off when the run has waited for it for too long.

        Only time in which this was called often counts: while the whole PC stood still, the client could not
        read either.
        """
        now_s = time.monotonic()
        passed_s, self._attended_s = now_s - self._attended_s, now_s
        if not self._out or not self._terms.lossless:
            self._waited_s = 0.0
        elif not self.gone:
            self._waited_s += min(passed_s, LONGEST_STEP_S)
            if self._waited_s > self._terms.stall_s:
                self._traffic.cut_off += 1
                self.cut_off = True
                self._lose(len(self._out))
                self._leave(f"took nothing for {self._waited_s:.0f} s and was cut off")

    def _lose(self, count: int) -> None:
        if not self._full and not self._terms.lossless:
            self._terms.tell(f"{self.name} does not keep up: it loses data until it has caught up")
        self._full = True
        self.lost += count
        self._traffic.lost += count

    def _write(self) -> None:
        try:
            while self._out:
                count = self._carrier.write(self._out)
                del self._out[:count]
                self._traffic.delivered += count
                self._waited_s = 0.0
        except BlockingIOError:
            pass
        except OSError:
            self._leave("went")
            return
        if self._full and not self._out:
            self._full = False
            self._terms.tell(f"{self.name} has caught up; it has lost {self.lost:,} bytes in all")
        self._watch()

    # -- from the client ---------------------------------------------------------------------------

    def take(self, room: int) -> bytes:
        """At most `room` bytes of what the client sent."""
        data = bytes(self._in[:room])
        if data:
            del self._in[: len(data)]
            self._traffic.taken += len(data)
            self._watch()
        return data

    @property
    def waiting(self) -> int:
        """Bytes that the client sent and nobody has taken yet."""
        return len(self._in)

    def read(self) -> None:
        """Take in what the client has sent."""
        try:
            data = self._carrier.read()
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.said_all = True
            if not self._answers_to_the_end:
                self._leave("went")
                return
        self._in += data
        self._watch()

    # ----------------------------------------------------------------------------------------------

    def close(self, gently: bool = True) -> None:
        """End it from this side."""
        if not self.gone:
            self.gone = True
            self._hub.watch(self._carrier.waited, None)
            self._carrier.close(gently)

    def _leave(self, how: str) -> None:
        left = f"; {len(self._out):,} bytes for it are dropped" if self._out and how == "went" else ""
        lost = f"; it has lost {self.lost:,} bytes" if self.lost else ""
        self._terms.tell(f"{self.name} {how}{left}{lost}")
        self._out.clear()
        self.close(gently=False)

    def _watch(self) -> None:
        """Wait for what matters: input while there is room for it, room while there is output."""
        if not self.gone:
            read = self.read if len(self._in) < INPUT_BYTES and not self.said_all else None
            self._hub.watch(self._carrier.waited, read, self._write if self._out else None)
