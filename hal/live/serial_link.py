"""A serial line that survives being unplugged: two threads move its bytes, and it opens its port again.

    open ──port vanishes──► down ──back-off 0.1, 0.2, … 5 s──► open again

Opening it for the first time tells what is wrong by an exception, since somebody is waiting for it. After
that nothing is raised: the link is *down* and counts. Bytes written meanwhile are lost, as on a cable that
nobody has plugged in.
"""

from __future__ import annotations

import array
import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import Condition, Thread
from typing import Any

from serial import SerialException

from hal.live.port import PortError, is_device, open_port

FIRST_PAUSE_S = 0.1
LONGEST_PAUSE_S = 5.0
TRANSMIT_BYTES = 4096
CHUNK_BYTES = 256
"""Handed to the system at a time, so that what is still queued can be counted."""
READ_BYTES = 4096
JOIN_S = 2.0

TIOCGICOUNT = 0x545D
"""Linux: the driver's counters since boot."""

Receiver = Callable[[bytes], None]


@dataclass
class LinkCounters:
    """What has happened on a link since it was first opened."""

    bytes_received: int = 0
    bytes_sent: int = 0
    bytes_lost: int = 0
    """Written while the link was down, or queued when it went down."""
    losses: int = 0
    """How often the port vanished."""
    reopenings: int = 0
    last_problem: str = ""


class SerialLink:
    """A port that `receiver` gets the bytes of, in a thread of the link's own."""

    def __init__(self, url: str, baud: int, receiver: Receiver | None = None) -> None:
        self.url = url
        self.counters = LinkCounters()
        self.receiver = receiver
        self.on_change: Callable[[bool], None] | None = None
        """Told from the link's thread: True when the port is there again, False when it has vanished."""
        self._baud = baud
        self._modem_lines: dict[str, bool] = {}
        self._queue = bytearray()
        self._wake = Condition()
        self._closing = False
        self._errors_seen = 0
        self._port: Any = open_port(url, baud)
        self._errors_seen = self._driver_errors(self._port)
        self._threads = [
            Thread(target=self._read_for_ever, name=f"read {url}", daemon=True),
            Thread(target=self._write_for_ever, name=f"write {url}", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    # -- for the peripherals ---------------------------------------------------------------------

    @property
    def is_open(self) -> bool:
        """Whether the port is there."""
        return self._port is not None

    @property
    def baud(self) -> int:
        """The rate, also while the port is away."""
        return self._baud

    def set_baud(self, baud: int) -> None:
        """Change the rate once what is queued has gone out. Raises ValueError for no rate at all."""
        if baud <= 0:
            raise ValueError(f"rate of {baud} baud on {self.url}; it must be positive, e.g. 9600")
        self._drain()
        self._baud = baud
        self._on_port(lambda port: setattr(port, "baudrate", baud))

    def write(self, data: bytes) -> int:
        """Queue bytes and return how many were taken; while the link is down they are lost."""
        with self._wake:
            if self._port is None:
                self.counters.bytes_lost += len(data)
                return len(data)
            taken = data[: TRANSMIT_BYTES - len(self._queue)]
            self._queue += taken
            self._wake.notify_all()
        return len(taken)

    def free(self) -> int:
        """Room left in the transmit queue."""
        return TRANSMIT_BYTES - len(self._queue)

    def set_modem_line(self, name: str, state: bool) -> None:
        """Set RTS or DTR now, and again whenever the port is opened."""
        self._modem_lines[name] = state
        self._on_port(lambda port: setattr(port, name, state))

    def modem_line(self, name: str) -> bool | None:
        """State of CTS, DSR, RI or CD; None while the port is away or has no such line."""
        port = self._port
        if port is None:
            return None
        try:
            return bool(getattr(port, name))
        except (OSError, SerialException):
            return None

    def take_errors(self) -> int:
        """Framing errors and overruns since the last call, where the port's driver counts them."""
        port = self._port
        if port is None:
            return 0
        seen = self._driver_errors(port)
        new, self._errors_seen = max(0, seen - self._errors_seen), seen
        return new

    def close(self) -> None:
        """Send what is queued, as far as that works, and let go of the port."""
        self._drain()
        with self._wake:
            self._closing = True
            port, self._port = self._port, None
            self._wake.notify_all()
        if port is not None:
            _close_quietly(port)
        for thread in self._threads:
            thread.join(JOIN_S)

    # -- the threads -----------------------------------------------------------------------------

    def _read_for_ever(self) -> None:
        pause = FIRST_PAUSE_S
        while not self._closing:
            port = self._port
            if port is None:
                pause = FIRST_PAUSE_S if self._open_again() else self._wait(pause)
                continue
            try:
                data = _read_what_is_there(port)
            except Exception as error:  # pyserial lets out whatever a vanishing port makes the system raise
                self._lose(port, error)
                continue
            if data:
                self.counters.bytes_received += len(data)
                if self.receiver is not None:
                    self.receiver(data)

    def _write_for_ever(self) -> None:
        while True:
            with self._wake:
                while not self._closing and (not self._queue or self._port is None):
                    self._wake.wait()
                if self._closing:
                    return
                port = self._port
                chunk = bytes(self._queue[:CHUNK_BYTES])
            try:
                port.write(chunk)
            except Exception as error:
                self._lose(port, error)
                continue
            with self._wake:
                if self._port is port:  # otherwise the queue was given up meanwhile
                    del self._queue[: len(chunk)]
                    self.counters.bytes_sent += len(chunk)
                    self._wake.notify_all()

    def _lose(self, port: Any, error: Exception) -> None:
        """The port has vanished, or was closed by ourselves."""
        with self._wake:
            if self._port is not port:
                return
            self._port = None
            self.counters.losses += 1
            self.counters.bytes_lost += len(self._queue)
            self.counters.last_problem = str(error)
            self._queue.clear()
            self._wake.notify_all()
        _close_quietly(port)
        if self.on_change is not None:
            self.on_change(False)

    def _open_again(self) -> bool:
        try:
            port = open_port(self.url, self._baud)
            for name, state in self._modem_lines.items():
                setattr(port, name, state)
        except (PortError, OSError) as error:
            self.counters.last_problem = str(error)
            return False
        self._errors_seen = self._driver_errors(port)
        with self._wake:
            if self._closing:
                _close_quietly(port)
                return False
            self._port = port
            self.counters.reopenings += 1
            self._wake.notify_all()
        if self.on_change is not None:
            self.on_change(True)
        return True

    def _wait(self, pause_s: float) -> float:
        """Wait before the next attempt; returns the pause after that."""
        with self._wake:
            if not self._closing:
                self._wake.wait(pause_s)
        return min(2.0 * pause_s, LONGEST_PAUSE_S)

    def _drain(self) -> None:
        deadline = time.monotonic() + JOIN_S
        with self._wake:
            while self._queue and self._port is not None and time.monotonic() < deadline:
                self._wake.wait(0.05)
            port = self._port
        if port is not None and is_device(self.url):
            try:
                port.flush()
            except (OSError, SerialException):
                return

    def _on_port(self, action: Callable[[Any], None]) -> None:
        port = self._port
        if port is None:
            return
        try:
            action(port)
        except (OSError, SerialException, ValueError) as error:
            self.counters.last_problem = str(error)

    def _driver_errors(self, port: Any) -> int:
        """Framing errors and overruns that the driver has counted; 0 where it does not."""
        try:
            import fcntl

            counters = array.array("i", [0] * 20)
            fcntl.ioctl(port.fileno(), TIOCGICOUNT, counters)
        except (ImportError, OSError, AttributeError, SerialException, ValueError):
            return 0
        # cts, dsr, rng, dcd, rx, tx, frame, overrun, parity, brk, buf_overrun
        return counters[6] + counters[7] + counters[10]


def _read_what_is_there(port: Any) -> bytes:
    """Wait for a byte and return it with all that have come with it; empty after the port's time-out."""
    data: bytes = port.read(1)
    if not data:
        return data
    waiting = port.in_waiting
    if waiting and type(port).__module__.endswith("protocol_socket"):
        # Its `in_waiting` only tells that there is something; without a time-out it hands out all of it.
        patience, port.timeout = port.timeout, 0
        try:
            return data + port.read(READ_BYTES)
        finally:
            port.timeout = patience
    return data + port.read(min(waiting, READ_BYTES)) if waiting else data


def _close_quietly(port: Any) -> None:
    try:
        port.close()
    except Exception:  # whatever is left of a vanished port
        return
