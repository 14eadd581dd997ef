"""Set-up of a receiver that takes sentences and acknowledges nothing: find its bit rate, switch it to the
wanted one, say what it shall send.

    listening ──a sentence──► switching ──understood at the new rate──► running
        ▲  └─ none: next bit rate   │ not understood                       │ silent
        └───────────────────────────┴──────────────────────────────────────┘

`step` never waits: the background calls it now and then. A set-up counts when sentences come at the wanted
rate; what it shall send is told in one go.
"""

from __future__ import annotations

from enum import Enum
from functools import reduce
from operator import xor
from typing import Final, Protocol

from firmware.drivers.receiver_stream import SECOND_NS, ReceiverStream
from hal.uart import Uart

LISTEN_NS: Final = 2_500_000_000
"""At each bit rate; a set comes every second, and takes up to a second at 4800 baud."""
SETTLE_NS: Final = 1_500_000_000
"""From the command to the new rate: what was queued leaves first."""
SILENT_NS: Final = 5 * SECOND_NS


def sentence(body: str) -> bytes:
    """`$body*hh` and the line end."""
    data = body.encode("ascii")
    return b"$%b*%02X\r\n" % (data, reduce(xor, data, 0))


class SentenceSetup(Protocol):
    """What one kind of receiver is told."""

    @property
    def baud(self) -> int:
        """The wanted bit rate."""
        ...

    @property
    def baud_rates(self) -> tuple[int, ...]:
        """In the order in which they are tried; the factory's first."""
        ...

    def port(self) -> bytes:
        """The command for the bit rate."""
        ...

    def rates(self) -> bytes:
        """The commands for what it shall send."""
        ...

    def rescue(self) -> bytes:
        """What brings it back to sentences from another protocol; empty when there is none."""
        ...


class SetupPhase(Enum):
    """Where the set-up stands."""

    LISTENING = "listening"
    SWITCHING = "changing the bit rate"
    RUNNING = "running"


class SentenceConfigurator:
    """Steps the set-up of one receiver."""

    def __init__(self, uart: Uart, stream: ReceiverStream, setup: SentenceSetup) -> None:
        self.phase = SetupPhase.LISTENING
        self.baud = stream.baud
        self.setups = 0
        """Times the receiver was set up to the end."""
        self._uart = uart
        self._stream = stream
        self._setup = setup
        self._tried = 0
        self._since_ns: int | None = None
        self._heard = 0
        self._heard_ns = 0
        self._sent = False

    def step(self, now_ns: int) -> None:
        """Look at what was heard, send what is due."""
        if self._since_ns is None:
            self._enter(SetupPhase.LISTENING, now_ns)
        fresh = self._stream.heard() != self._heard
        if fresh:
            self._heard, self._heard_ns = self._stream.heard(), now_ns
        if self.phase is SetupPhase.LISTENING:
            self._listen(now_ns, fresh)
        elif self.phase is SetupPhase.SWITCHING:
            self._switch(now_ns, fresh)
        elif now_ns - self._heard_ns > SILENT_NS:
            self._enter(SetupPhase.LISTENING, now_ns)

    def _enter(self, phase: SetupPhase, now_ns: int) -> None:
        self.phase = phase
        self._since_ns = self._heard_ns = now_ns
        self._heard = self._stream.heard()
        self._sent = False

    def _elapsed(self, now_ns: int) -> int:
        assert self._since_ns is not None
        return now_ns - self._since_ns

    def _listen(self, now_ns: int, fresh: bool) -> None:
        if fresh:
            self._enter(SetupPhase.SWITCHING, now_ns)
        elif self._elapsed(now_ns) > LISTEN_NS:
            if self._setup.rescue() and not self._sent:
                # no sentences: perhaps it speaks another protocol at this rate, and listens
                self._sent = self._send(self._setup.rescue())
                self._since_ns = now_ns - LISTEN_NS + SETTLE_NS
                return
            if self._sent and self.baud != self._setup.baud:
                self._set_baud(self._setup.baud)
            else:
                self._tried += 1
                self._set_baud(self._setup.baud_rates[self._tried % len(self._setup.baud_rates)])
            self._enter(SetupPhase.LISTENING, now_ns)

    def _switch(self, now_ns: int, fresh: bool) -> None:
        """At the old rate send the command, follow; at the new one wait for a sentence, then ask for more."""
        if self.baud != self._setup.baud:
            if not self._sent:
                self._sent = self._send(self._setup.port())
            elif self._elapsed(now_ns) > SETTLE_NS:
                self._set_baud(self._setup.baud)
                self._enter(SetupPhase.SWITCHING, now_ns)
        elif fresh:
            if self._send(self._setup.rates()):
                self.setups += 1
                self._enter(SetupPhase.RUNNING, now_ns)
        elif self._elapsed(now_ns) > LISTEN_NS:
            self._enter(SetupPhase.LISTENING, now_ns)

    def _set_baud(self, baud: int) -> None:
        self.baud = baud
        self._uart.set_baud(baud)
        self._stream.set_baud(baud)

    def _send(self, message: bytes) -> bool:
        """Queue all of it, or nothing."""
        return self._uart.tx_free() >= len(message) and self._uart.write(message) == len(message)
