"""A serial port offered by RFC 2217: pyserial's own server side, in threads."""

from __future__ import annotations

import socket
from contextlib import suppress
from threading import Thread

import serial
from serial.rfc2217 import PortManager


class _WithoutModemLines(serial.Serial):
    """A pseudo-terminal has none, which the server side of pyserial does not expect."""

    cts = dsr = ri = cd = False

    def _update_dtr_state(self) -> None:
        pass

    def _update_rts_state(self) -> None:
        pass


class Rfc2217Server:
    """Offers the port at `path` to one client at a time on `port` of this computer."""

    def __init__(self, path: str) -> None:
        self._serial = _WithoutModemLines(path, timeout=0.02)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(0.05)
        self.port = self._listener.getsockname()[1]
        self._manager: PortManager | None = None
        self._client: socket.socket | None = None
        self._closing = False
        self._threads = [Thread(target=self._accept, daemon=True), Thread(target=self._forward, daemon=True)]
        for thread in self._threads:
            thread.start()

    def write(self, data: bytes) -> None:
        """The manager answers its client by this."""
        if self._client is not None:
            with suppress(OSError):
                self._client.sendall(data)

    def close(self) -> None:
        self._closing = True
        self._listener.close()
        if self._client is not None:
            self._client.close()
        for thread in self._threads:
            thread.join(2.0)
        self._serial.close()

    def _accept(self) -> None:
        while not self._closing:
            try:
                self._client, _ = self._listener.accept()
                self._client.settimeout(None)
                self._manager = PortManager(self._serial, self)
                while data := self._client.recv(1024):
                    self._serial.write(b"".join(self._manager.filter(data)))
            except OSError:
                continue

    def _forward(self) -> None:
        while not self._closing:
            data = self._serial.read(max(1, self._serial.in_waiting))
            if data and self._manager is not None:
                self.write(b"".join(self._manager.escape(data)))
