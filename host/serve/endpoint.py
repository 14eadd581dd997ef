"""What a served serial line ends in: the protocol of PTY, TCP and RFC 2217, and what they count."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from host.serve.hub import Hub

Tell = Callable[[str], None]
"""Takes a line for people: who came, went, stalled, lost something."""


@dataclass
class Terms:
    """How an endpoint treats its clients."""

    tell: Tell
    stall_s: float = 10.0
    """While lossless: a client that takes nothing for so long is cut off."""
    lossless: bool = False
    """True: the run waits for clients that read (no pace); False: who does not keep up loses data."""
    line_baud: Callable[[], int] | None = None
    """The line's bit rate now."""


@dataclass
class Traffic:
    """What went through an endpoint, over all its clients."""

    clients: int = 0
    """Who came, in all."""
    delivered: int = 0
    """Bytes handed to clients."""
    lost: int = 0
    """Bytes that clients did not get because they did not keep up."""
    taken: int = 0
    """Bytes that clients sent."""
    cut_off: int = 0
    """Clients that stalled and were cut off."""


class Endpoint(Protocol):
    """One end of a served serial line. Nothing in here blocks."""

    where: str
    """As people name it, e.g. "/dev/pts/3" or "tcp://127.0.0.1:5760"."""
    traffic: Traffic

    def open(self, hub: Hub, terms: Terms) -> None:
        """Be there for clients. Raises UserError when that cannot be."""
        ...

    def send(self, data: bytes) -> None:
        """Bytes of the line, for every client."""
        ...

    def take(self, room: int) -> bytes:
        """At most `room` bytes of what clients sent, each client's in their order."""
        ...

    def attend(self) -> None:
        """Called every slice: look after clients that nobody reports, and stalled ones."""
        ...

    @property
    def present(self) -> int:
        """Clients now."""
        ...

    @property
    def backlog(self) -> int:
        """Bytes that the slowest client has not been given yet."""
        ...

    @property
    def waiting(self) -> int:
        """Bytes that clients wrote and the line has not taken yet."""
        ...

    def finish(self) -> bool:
        """Called again and again at the end: hand over what is left; whether there is nothing left."""
        ...

    def close(self) -> None:
        """Be gone."""
        ...
