"""HOST:PORT of something to be served, and why only this machine may reach it."""

from __future__ import annotations

import ipaddress
import socket
from dataclasses import dataclass

from host.record.errors import UserError

LOCAL_NAMES = ("localhost", "ip6-localhost")


@dataclass(frozen=True)
class Address:
    """Where to listen. Port 0: any free one."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


def parse_address(text: str, option: str, example: str) -> Address:
    """From "127.0.0.1:5760", "localhost:5760" or "[::1]:5760". Raises UserError."""
    host, colon, port = text.rpartition(":")
    host = host[1:-1] if host.startswith("[") and host.endswith("]") else host
    if not colon or not host or not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise UserError(f"{option}: {text!r} is no HOST:PORT with a port in 0 … 65535; for example {example}")
    return Address(host, int(port))


def check_local(address: Address, option: str, allow_remote: bool) -> None:
    """Raises UserError for an address that other machines could reach, unless that was asked for."""
    if allow_remote or address.host in LOCAL_NAMES:
        return
    try:
        local = ipaddress.ip_address(address.host).is_loopback
    except ValueError:
        local = False
    if not local:
        raise UserError(
            f"{option}: {address} could be reached from other machines, and whoever reaches it can write to"
            f" the board; use 127.0.0.1:{address.port}, or say --allow-remote if that is meant"
        )


def listen(address: Address, option: str) -> socket.socket:
    """A socket that listens there and does not block. Raises UserError."""
    try:
        family, _kind, _protocol, _name, place = socket.getaddrinfo(
            address.host, address.port, type=socket.SOCK_STREAM
        )[0]
        listener = socket.socket(family, socket.SOCK_STREAM)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(place)
            listener.listen()
        except OSError:
            listener.close()
            raise
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError(
            f"{option}: cannot listen at {address}: {reason}; name another port, e.g. {address.port + 1}"
        ) from None
    listener.setblocking(False)
    return listener
