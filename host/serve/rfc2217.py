"""RFC 2217: a serial line over Telnet, by pyserial's own server side.

Clients may set what they like: bit rate, parity, modem lines are remembered and answered as asked, so that
every client opens. The line's rate is the board's; bytes pass as they are, and a rate that is not the line's
is told (`told_baud`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import serial.rfc2217

from host.serve.stream import Carrier, Stream

IAC = b"\xff"
LONGEST_OPTION = 4096
PORT_MANAGER: Any = serial.rfc2217.PortManager
"""It asks for a serial port and a connection, and takes whatever has their attributes."""


def escaped(data: bytes) -> bytes:
    """As Telnet carries it."""
    return data.replace(IAC, IAC + IAC) if IAC in data else data


class PretendedPort:
    """What `serial.rfc2217.PortManager` takes for the port that it manages."""

    def __init__(self, told_baud: Callable[[int], None]) -> None:
        self._told_baud = told_baud
        self._baudrate = 9600
        self.bytesize = serial.EIGHTBITS
        self.parity = serial.PARITY_NONE
        self.stopbits: float = serial.STOPBITS_ONE
        self.xonxoff = self.rtscts = self.break_condition = False
        self.rts = self.dtr = self.cts = self.dsr = self.cd = True
        self.ri = False

    @property
    def baudrate(self) -> int:
        """As asked for last."""
        return self._baudrate

    @baudrate.setter
    def baudrate(self, asked: int) -> None:
        self._baudrate = asked
        self._told_baud(asked)

    def reset_input_buffer(self) -> None:
        """Nothing waits here."""

    def reset_output_buffer(self) -> None:
        """Nothing waits here."""


class Telnet:
    """A carrier of bytes in Telnet on top of another. Implements `host.serve.stream.Carrier`."""

    def __init__(self, carrier: Carrier, told_baud: Callable[[int], None]) -> None:
        self.waited = carrier.waited
        self.close = carrier.close
        self.write = carrier.write
        """Whoever sends has the bytes `escaped`: a piece may be taken in part."""
        self._carrier = carrier
        self._port = PretendedPort(told_baud)
        self._manager: Any = None

    def reply_by(self, stream: Stream) -> None:
        """Begin to negotiate; answers go through `stream`."""
        self._manager = PORT_MANAGER(self._port, _Replies(stream))

    def read(self) -> bytes:
        """What the client sent on the line. Raises BlockingIOError when that is nothing."""
        data = self._carrier.read()
        if not data:
            return b""
        found = self._filtered(data)
        if not found:
            raise BlockingIOError
        return found

    def _filtered(self, data: bytes) -> bytes:
        manager = self._manager
        if IAC not in data and manager.mode == serial.rfc2217.M_NORMAL and manager.suboption is None:
            return data
        found = bytearray()
        for value in data:
            try:
                for piece in manager.filter(bytes((value,))):
                    found += piece
            except Exception:  # what the library does not expect of a client is many things
                manager.mode, manager.suboption = serial.rfc2217.M_NORMAL, None
            if manager.suboption is not None and len(manager.suboption) > LONGEST_OPTION:
                manager.suboption = None
        return bytes(found)


class _Replies:
    """What `PortManager` writes to."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream

    def write(self, data: bytes) -> None:
        """An answer of the protocol."""
        self._stream.send_aside(bytes(data))
