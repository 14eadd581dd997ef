"""A served serial line on TCP: raw bytes, or RFC 2217; any number of clients up to `MOST_CLIENTS`."""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Callable

from host.serve.address import Address, listen
from host.serve.endpoint import Terms, Traffic
from host.serve.hub import Hub, Waited
from host.serve.rfc2217 import Telnet, escaped
from host.serve.stream import READ_BYTES, Carrier, Stream

MOST_CLIENTS = 32
MOST_WAITING_BYTES = 1 << 20
"""Written by clients, also by such as have gone, and waiting for the line: some 45 s at 230,400 baud."""
GOODBYE_S = 1.0
SYSTEM_BUFFER_BYTES = 1 << 16
"""What the system keeps for a client besides its stream's buffer: by itself it would take megabytes."""


class SocketCarrier:
    """Bytes as they are."""

    def __init__(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        with contextlib.suppress(OSError):
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SYSTEM_BUFFER_BYTES)
        self.waited: Waited = connection
        self._connection = connection

    def read(self) -> bytes:
        """What has come."""
        return self._connection.recv(READ_BYTES)

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Hand over."""
        return self._connection.send(data)

    def close(self, gently: bool) -> None:
        """Gently: input that nobody has read would break off what the client was given."""
        with contextlib.suppress(OSError):
            if gently:
                self._connection.shutdown(socket.SHUT_WR)
                self._connection.settimeout(GOODBYE_S)
                until = time.monotonic() + GOODBYE_S
                while time.monotonic() < until and self._connection.recv(READ_BYTES):
                    pass
        self._connection.close()


class SocketEndpoint:
    """Implements `host.serve.endpoint.Endpoint`."""

    def __init__(self, line: str, address: Address, option: str, telnet: bool = False) -> None:
        self.line = line
        self.traffic = Traffic()
        self.where = ""
        self._address = address
        self._option = option
        self._telnet = telnet
        self._streams: list[Stream] = []
        self._turn = 0

    def open(self, hub: Hub, terms: Terms) -> None:
        """Listen. Raises UserError."""
        self._hub, self._terms = hub, terms
        self._listener = listen(self._address, self._option)
        host, port = self._listener.getsockname()[:2]
        scheme = "rfc2217" if self._telnet else "tcp"
        self.where = f"{scheme}://{Address(host, port)}"
        hub.watch(self._listener, self._accept)

    def send(self, data: bytes) -> None:
        """To every client."""
        data = escaped(data) if self._telnet else data
        for stream in self._streams:
            stream.send(data)

    def take(self, room: int) -> bytes:
        """Of the clients in turn."""
        pieces = []
        count = len(self._streams)
        for k in range(count):
            stream = self._streams[(self._turn + k) % count]
            if stream.waiting and room > 0:
                pieces.append(stream.take(room))
                room -= len(pieces[-1])
        self._turn += 1
        return b"".join(pieces)

    def attend(self) -> None:
        """Forget who has gone."""
        for stream in self._streams:
            stream.attend()
        if any(stream.gone for stream in self._streams):
            self._streams = [stream for stream in self._streams if not stream.gone or stream.waiting]

    @property
    def present(self) -> int:
        """Clients now."""
        return sum(not stream.gone for stream in self._streams)

    @property
    def backlog(self) -> int:
        """Of the slowest client."""
        return max((stream.backlog for stream in self._streams), default=0)

    @property
    def waiting(self) -> int:
        """Of all clients, those too that have gone."""
        return sum(stream.waiting for stream in self._streams)

    def finish(self) -> bool:
        """Whether every client has been handed everything."""
        return not self.backlog

    def close(self) -> None:
        """End all connections."""
        for stream in self._streams:
            stream.close()
        self._hub.watch(self._listener, None)
        self._listener.close()

    def _accept(self) -> None:
        try:
            connection, peer = self._listener.accept()
        except OSError:
            return
        name = f"client {Address(*peer[:2])} of {self.line}"
        if self.present >= MOST_CLIENTS:
            self._terms.tell(f"{name} is turned away: there are {MOST_CLIENTS} already")
            connection.close()
            return
        if self.waiting >= MOST_WAITING_BYTES:
            self._terms.tell(
                f"{name} is turned away: {self.waiting:,} bytes that others wrote still wait for the line"
            )
            connection.close()
            return
        self.traffic.clients += 1
        self._terms.tell(f"{name} came")
        self._streams.append(self._stream(connection, name))

    def _stream(self, connection: socket.socket, name: str) -> Stream:
        carrier: Carrier = SocketCarrier(connection)
        if not self._telnet:
            return Stream(self._hub, carrier, name, self._terms, self.traffic)
        telnet = Telnet(carrier, self._told_baud(name))
        stream = Stream(self._hub, telnet, name, self._terms, self.traffic)
        telnet.reply_by(stream)
        return stream

    def _told_baud(self, name: str) -> Callable[[int], None]:
        """What to do when a client asks for a bit rate."""

        def told(asked: int) -> None:
            line_baud = None if self._terms.line_baud is None else self._terms.line_baud()
            if line_baud is not None and asked != line_baud:
                self._terms.tell(
                    f"{name} asks for {asked} baud; the line runs at {line_baud}: bytes pass as they are"
                )

        return told
