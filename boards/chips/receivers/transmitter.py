"""The transmit buffer of the receiver's UART and the change of its baud rate.

The buffer is bounded: a message that does not fit is dropped whole (never a part of it), and while that
goes on the receiver says "txbuf alloc" in an error text once a second, as real ones do. The size is a
choice (2048 bytes, about two seconds at 9600 baud); the manufacturer gives none.

A new baud rate takes effect when everything queued before it, the acknowledgement last, has left at the
old rate (fact sheet section 7), plus one character; messages that come meanwhile wait for the new rate.
"""

from __future__ import annotations

from collections.abc import Callable

from boards.chips.receivers.utc import SECOND
from boards.chips.transmit_line import TransmitLine
from hal.emulated.virtual_time import Event, VirtualTime

BUFFER_BYTES = 2048
BITS_A_BYTE = 10


class Transmitter:
    """Queues whole messages onto the line. `dropped` counts the messages that found no room."""

    def __init__(
        self,
        time: VirtualTime,
        line: TransmitLine,
        capacity: int = BUFFER_BYTES,
        overrun_text: Callable[[], bytes] = bytes,
    ) -> None:
        self.baud = 0
        self.dropped = 0
        self.capacity = capacity
        self._time = time
        self._line = line
        self._abort: Callable[[], None] | None = getattr(line, "abort", None)
        self._overrun_text = overrun_text
        self._idle_at_ns = 0
        self._waiting: list[bytes] = []
        self._change: Event | None = None
        self._next_text_ns: int | None = None
        self._when_idle: Event | None = None

    def start(self, baud: int) -> None:
        """The port comes up with nothing queued."""
        self.baud = baud
        self._line.set_baud(baud)
        self._idle_at_ns = self._time.now
        self._next_text_ns = None

    def stop(self) -> None:
        """The supply or a reset takes the port away: what waits is lost, and what a line that can stop
        at once (`abort`) has not sent yet."""
        for event in (self._change, self._when_idle):
            if event is not None:
                event.cancel()
        self._change = self._when_idle = None
        self._waiting.clear()
        if self._abort is not None:
            self._abort()

    def queued(self) -> int:
        """Bytes that have not left yet."""
        backlog_ns = self._idle_at_ns - self._time.now
        if backlog_ns <= 0 and not self._waiting:
            return 0
        on_line = -(-backlog_ns * self.baud // (BITS_A_BYTE * SECOND)) if backlog_ns > 0 else 0
        return on_line + sum(map(len, self._waiting))

    def send(self, messages: list[bytes]) -> None:
        """Queue messages; those without room are dropped, each one whole."""
        free = self.capacity - self.queued()
        if self._next_text_ns is not None and self._time.now >= self._next_text_ns:
            text = self._overrun_text()
            if len(text) <= free:
                self._next_text_ns = None
                messages = [text, *messages]
        data = b"".join(messages)
        if len(data) > free:
            data = b"".join(self._fitting(messages, free))
        if data:
            self._put(data)

    def change_baud(self, baud: int) -> None:
        """Switch to `baud` once everything queued has left."""
        if baud == self.baud and self._change is None:
            return
        if self._change is not None:
            self._change.cancel()
        at = max(self._idle_at_ns, self._time.now) + BITS_A_BYTE * SECOND // self.baud
        self._change = self._time.at(at, lambda: self._switch(baud))

    def when_idle(self, callback: Callable[[], None]) -> None:
        """Run `callback` once everything queued has left; a second call replaces the first."""
        if self._when_idle is not None:
            self._when_idle.cancel()
        self._when_idle = self._time.at(max(self._idle_at_ns, self._time.now), callback)

    def _fitting(self, messages: list[bytes], free: int) -> list[bytes]:
        """The messages that fit one after the other; the others are counted and spoken of later."""
        kept = []
        for message in messages:
            if len(message) <= free:
                free -= len(message)
                kept.append(message)
            else:
                self.dropped += 1
                if self._next_text_ns is None:
                    self._next_text_ns = self._time.now + SECOND
        return kept

    def _put(self, data: bytes) -> None:
        if self._change is not None:
            self._waiting.append(data)
            return
        now = self._time.now
        start = self._idle_at_ns if self._idle_at_ns > now else now
        self._idle_at_ns = start + len(data) * BITS_A_BYTE * SECOND // self.baud
        self._line.send(data)

    def _switch(self, baud: int) -> None:
        self._change = None
        self.baud = baud
        self._line.set_baud(baud)
        waiting, self._waiting = self._waiting, []
        for data in waiting:
            self._put(data)
