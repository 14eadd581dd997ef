"""A CAN bus of python-can that survives being unplugged: it opens its interface again.

    open ──device gone, or ERRORS_IN_A_ROW──► down ──back-off 0.2, 0.4, … 5 s──► open again

Interfaces tell a device that has gone by an OSError (serial adapters) or by one CAN error after the other;
single CAN errors are what somebody else sent. Opening it for the first time raises; after that nothing is
raised: `recv` waits, and `send` tells that the frame was not taken.
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from time import monotonic, sleep
from typing import Any

import can

ERRORS_IN_A_ROW = 5
PAUSE_S = 0.2
LONGEST_PAUSE_S = 5.0
TROUBLES = (can.CanError, OSError, ValueError)


class CanLink:
    """One thread receives; any other may send."""

    def __init__(self, interface: str, channel: str, **options: Any) -> None:
        """Raises whatever the interface raises when it cannot be opened."""
        self.losses = 0
        """How often the bus vanished."""
        self.reopenings = 0
        self.errors = 0
        """What was received and made no sense, or could not be."""
        self.last_problem = ""
        self._open = partial(can.Bus, interface=interface, channel=channel, **options)
        self._bus: Any = self._open()
        self._bad = 0
        self._pause_s = PAUSE_S
        self._next_try_s = 0.0
        self._closing = False

    @property
    def is_open(self) -> bool:
        """Whether the bus is there."""
        return self._bus is not None

    def send(self, message: can.Message) -> bool:
        """Whether the interface took the message."""
        bus = self._bus
        if bus is None:
            return False
        try:
            bus.send(message)
        except TROUBLES as error:
            self.last_problem = str(error)
            return False
        return True

    def recv(self, timeout_s: float) -> can.Message | None:
        """The next message, or None when none came in time, or none that makes sense."""
        bus = self._bus
        if bus is None:
            self._open_again(timeout_s)
            return None
        try:
            message: can.Message | None = bus.recv(timeout_s)
        except TROUBLES as error:
            if not self._closing:
                self._trouble(error, timeout_s)
            return None
        if message is not None:
            self._bad = 0
        return message

    def close(self) -> None:
        """Leave the bus; call it when nobody receives any more."""
        self._closing = True
        self._let_go()

    def _trouble(self, error: Exception, timeout_s: float) -> None:
        self.errors += 1
        self._bad += 1
        self.last_problem = str(error)
        is_gone = isinstance(error, OSError) and not isinstance(error, can.CanError)
        if is_gone or self._bad >= ERRORS_IN_A_ROW:
            self.losses += 1
            self._pause_s = PAUSE_S
            self._next_try_s = monotonic() + self._pause_s
            self._let_go()
        elif self._bad > 1:
            sleep(min(timeout_s, PAUSE_S))

    def _open_again(self, timeout_s: float) -> None:
        wait_s = self._next_try_s - monotonic()
        if wait_s > 0.0:
            sleep(min(wait_s, timeout_s))
            return
        try:
            self._bus = self._open()
        except Exception as error:  # each interface raises its own
            self.last_problem = str(error)
            self._pause_s = min(2.0 * self._pause_s, LONGEST_PAUSE_S)
            self._next_try_s = monotonic() + self._pause_s
            return
        self._bad = 0
        self.reopenings += 1

    def _let_go(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            with suppress(Exception):  # whatever is left of a vanished interface
                bus.shutdown()
