"""Where a board's lines are to be served: `--uart NAME=URL` and `--can [NAME=]INTERFACE:CHANNEL`.

| URL | endpoint |
| --- | --- |
| pty | a pseudo-terminal; its path is told |
| pty:./gnss | the same, with a link of this name |
| tcp://127.0.0.1:5760 | raw bytes on TCP |
| rfc2217://127.0.0.1:4000 | serial over Telnet |
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from boards.description import Board
from boards.hints import did_you_mean
from host.record.errors import UserError
from host.serve.address import check_local, parse_address
from host.serve.endpoint import Endpoint
from host.serve.sockets import SocketEndpoint

UART_EXAMPLE = "--uart host=tcp://127.0.0.1:5760"
CAN_EXAMPLE = "--can can1=udp_multicast:239.74.163.2"
SCHEMES = {"tcp": False, "rfc2217": True}


@dataclass(frozen=True)
class CanPlace:
    """A CAN bus of the board and the interface of python-can at which it is served."""

    bus: str
    interface: str
    channel: str

    @property
    def option(self) -> str:
        """As it was asked for."""
        return f"--can {self.bus}={self.interface}:{self.channel}"


def uart_endpoints(given: Sequence[str], board: Board, allow_remote: bool) -> dict[str, Endpoint]:
    """The endpoint of every UART that is to be served. Raises UserError."""
    endpoints: dict[str, Endpoint] = {}
    for text in given:
        name, equals, url = text.partition("=")
        if not equals:
            raise UserError(f"--uart {text}: tells no UART or no place; for example {UART_EXAMPLE}")
        if name not in board.uarts:
            hint = did_you_mean(name, board.uarts)
            raise UserError(f"--uart {text}: the board {board.name} has no UART {name!r}; {hint}")
        if name in endpoints:
            raise UserError(f"--uart {text}: {name!r} is served already; a UART has one place")
        endpoints[name] = _endpoint(name, url, f"--uart {text}", allow_remote)
    return endpoints


def _endpoint(name: str, url: str, option: str, allow_remote: bool) -> Endpoint:
    scheme, separator, rest = url.partition("://")
    if separator and scheme in SCHEMES:
        address = parse_address(rest.rstrip("/"), option, f"{scheme}://127.0.0.1:5760")
        check_local(address, option, allow_remote)
        return SocketEndpoint(name, address, option, telnet=SCHEMES[scheme])
    kind, colon, link = url.partition(":")
    if kind == "pty" and not link.startswith("//") and (link or not colon):
        try:
            from host.serve.pty_link import PtyEndpoint
        except ImportError:
            raise UserError(
                f"{option}: this system has no pseudo-terminals; use tcp://127.0.0.1:5760"
            ) from None
        return PtyEndpoint(name, Path(link) if link else None, option)
    raise UserError(
        f"{option}: {url!r} is no place; there are pty, pty:./{name}, tcp://127.0.0.1:5760 and"
        " rfc2217://127.0.0.1:4000"
    )


def can_places(given: Sequence[str], board: Board) -> list[CanPlace]:
    """The interface of every CAN bus that is to be served; the name may be left out when there is one bus.

    Raises UserError.
    """
    places: list[CanPlace] = []
    for text in given:
        name, equals, place = text.partition("=")
        if not equals:
            name, place = _only_bus(board, text), text
        if name not in board.can:
            hint = did_you_mean(name, board.can)
            raise UserError(f"--can {text}: the board {board.name} has no CAN bus {name!r}; {hint}")
        interface, colon, channel = place.partition(":")
        if not interface or not colon or not channel:
            raise UserError(f"--can {text}: tells no INTERFACE:CHANNEL; for example {CAN_EXAMPLE}")
        if any(known.bus == name for known in places):
            raise UserError(f"--can {text}: {name!r} is served already; a CAN bus has one place")
        places.append(CanPlace(name, interface, channel))
    return places


def _only_bus(board: Board, text: str) -> str:
    if len(board.can) == 1:
        return next(iter(board.can))
    known = ", ".join(board.can) or "none"
    raise UserError(f"--can {text}: name the bus (there is: {known}); for example {CAN_EXAMPLE}")
