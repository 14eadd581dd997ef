"""A serial port made of a pseudo-terminal, that can be plugged in, unplugged and plugged in again.

Programs open `path`, which is a link that exists while the port is plugged in, like the device of a USB
adapter.
"""

from __future__ import annotations

import os
import select
import termios
import tty
from collections.abc import Callable
from pathlib import Path
from threading import Thread

RATES = {
    getattr(termios, f"B{rate}"): rate for rate in (1200, 4800, 9600, 19200, 38400, 57600, 115200, 230400)
}

Receiver = Callable[[bytes], bytes | None]
"""Gets what the program has written, returns what the device answers."""


class PtyPort:
    """The device's end. `receiver` runs in a thread of its own."""

    def __init__(self, path: Path, receiver: Receiver | None = None) -> None:
        self.path = path
        self.receiver = receiver
        self.written = bytearray()
        """Everything that the program has written."""
        self._master = -1
        self._slave = -1
        self._thread: Thread | None = None
        self.plug_in()

    def plug_in(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path.symlink_to(os.ttyname(self._slave))
        self._stop_read, self._stop = os.pipe()
        self._thread = Thread(target=self._serve, args=(self._master, self._stop_read), daemon=True)
        self._thread.start()

    def unplug(self) -> None:
        if self._master < 0:
            return
        self.path.unlink()
        os.write(self._stop, b"x")
        assert self._thread is not None
        self._thread.join()
        for descriptor in (self._master, self._slave, self._stop, self._stop_read):
            os.close(descriptor)
        self._master = self._slave = -1

    def send(self, data: bytes) -> None:
        view = memoryview(data)
        while view:
            view = view[os.write(self._master, view) :]

    @property
    def baud(self) -> int:
        """The rate that the program has set."""
        return RATES[termios.tcgetattr(self._master)[4]]

    def __enter__(self) -> PtyPort:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def _serve(self, master: int, stop: int) -> None:
        while True:
            ready, _, _ = select.select([master, stop], [], [])
            if stop in ready:
                return
            data = os.read(master, 4096)
            self.written += data
            answer = self.receiver(data) if self.receiver is not None else None
            if answer:
                os.write(master, answer)
