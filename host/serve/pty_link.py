"""A served serial line as a pseudo-terminal: any program that opens a serial port can open it.

The terminal is raw (no echo, no line editing) from the start. Nobody can see who opens it; that somebody has
it open is all that the system tells, so all who do are one client here, and they share what comes.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import select
import struct
import termios
import time
import tty
from pathlib import Path

from host.record.errors import UserError
from host.serve.endpoint import Terms, Traffic
from host.serve.hub import Hub, Waited
from host.serve.stream import INPUT_BYTES, READ_BYTES, Stream

LOOK_EVERY_S = 0.02
SETTLED_S = 0.1


class MasterCarrier:
    """The master's side of the pair."""

    def __init__(self, master: int) -> None:
        self.waited: Waited = master
        self._master = master

    def read(self) -> bytes:
        """What has come."""
        return os.read(self._master, READ_BYTES)

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Hand over."""
        return os.write(self._master, data)

    def close(self, gently: bool) -> None:
        """The pair stays: another client may open it."""


class PtyEndpoint:
    """Implements `host.serve.endpoint.Endpoint`. `link`: a name that leads to the terminal meanwhile."""

    def __init__(self, line: str, link: Path | None, option: str) -> None:
        self.line = line
        self.traffic = Traffic()
        self.where = ""
        self._link = link
        self._option = option
        self._stream: Stream | None = None
        self._left = bytearray()
        """What clients wrote who have gone since."""
        self._barred = False
        """Whoever has it open was cut off; opened anew it is served again."""
        self._looked_s = 0.0
        self._empty_since_s: float | None = None
        self._linked = False

    def open(self, hub: Hub, terms: Terms) -> None:
        """Make the pair and the link. Raises UserError."""
        self._hub, self._terms = hub, terms
        if self._link is not None:
            self._check_link(self._link)
        try:
            self._master, slave = os.openpty()
        except OSError as error:
            raise UserError(f"{self._option}: no pseudo-terminal can be had: {error.strerror}") from None
        tty.setraw(slave)
        self._slave_name = os.ttyname(slave)
        os.set_blocking(self._master, False)
        os.close(slave)
        if self._link is not None:
            self._make_link(self._link)
        self.where = str(self._link) if self._link is not None else self._slave_name
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)

    def send(self, data: bytes) -> None:
        """To whoever has it open."""
        if self._stream is not None:
            self._stream.send(data)

    def take(self, room: int) -> bytes:
        """What was written to it."""
        data = bytes(self._left[:room])
        del self._left[: len(data)]
        return data if self._stream is None else data + self._stream.take(room - len(data))

    def attend(self) -> None:
        """Notice who came and went."""
        now_s = time.monotonic()
        if self._stream is not None:
            self._stream.attend()
            if self._stream.gone and len(self._left) + self._stream.waiting <= INPUT_BYTES:
                self._left += self._stream.take(INPUT_BYTES)
                self._barred = self._stream.cut_off and self._is_open()
                self._stream = None
                self._throw_away()
            return
        if now_s - self._looked_s >= LOOK_EVERY_S:
            self._looked_s = now_s
            is_open = self._is_open()
            if self._barred:
                self._barred = is_open
            elif is_open:
                self._come()

    @property
    def present(self) -> int:
        """Whether it is open."""
        return int(self._stream is not None and not self._stream.gone)

    @property
    def backlog(self) -> int:
        """What waits to be handed over."""
        return 0 if self._stream is None else self._stream.backlog

    @property
    def waiting(self) -> int:
        """Of who has it open, and of who had."""
        return len(self._left) + (0 if self._stream is None else self._stream.waiting)

    def finish(self) -> bool:
        """Whether all has been read: what is left in the terminal is lost when it ends."""
        if self.backlog:
            return False
        if not self.present:
            return True
        if self._unread():
            self._empty_since_s = None
            return False
        now_s = time.monotonic()
        self._empty_since_s = self._empty_since_s or now_s
        return now_s - self._empty_since_s >= SETTLED_S

    def close(self) -> None:
        """End it, and take the link away."""
        if self._stream is not None:
            self._stream.close()
        if self._linked and self._link is not None:
            with contextlib.suppress(OSError):
                if os.readlink(self._link) == self._slave_name:
                    self._link.unlink()
        os.close(self._master)

    def _come(self) -> None:
        self.traffic.clients += 1
        name = f"client of {self.line} at {self.where}"
        self._terms.tell(f"{name} came")
        self._stream = Stream(self._hub, MasterCarrier(self._master), name, self._terms, self.traffic)

    def _is_open(self) -> bool:
        return not any(events & select.POLLHUP for _fd, events in self._poll.poll(0))

    def _throw_away(self) -> None:
        """What the last client has not read is not for the next one."""
        with contextlib.suppress(OSError, termios.error):
            slave = os.open(self._slave_name, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                termios.tcflush(self._master, termios.TCOFLUSH)  # what the next one writes stays
                termios.tcflush(slave, termios.TCIFLUSH)
            finally:
                os.close(slave)

    def _unread(self) -> int:
        """Bytes in the terminal that nobody has read."""
        try:
            slave = os.open(self._slave_name, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError:
            return 0
        try:
            return int(struct.unpack("i", fcntl.ioctl(slave, termios.FIONREAD, b"\0\0\0\0"))[0])
        except OSError:
            return 0
        finally:
            os.close(slave)

    def _check_link(self, link: Path) -> None:
        if link.is_symlink() and not link.exists():
            return  # left behind by a run that was killed
        if link.is_symlink() or link.exists():
            raise UserError(
                f"{self._option}: {link} exists; name a path that does not, e.g. pty:{link}-2, or remove it"
            )

    def _make_link(self, link: Path) -> None:
        try:
            if link.is_symlink():
                link.unlink()
            link.symlink_to(self._slave_name)
        except OSError as error:
            os.close(self._master)
            reason = "it exists" if error.errno == errno.EEXIST else error.strerror
            raise UserError(f"{self._option}: the link {link} cannot be made: {reason}") from None
        self._linked = True
