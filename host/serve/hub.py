"""One place where everything outside is waited for: sockets, pseudo-terminals, and the time."""

from __future__ import annotations

import selectors
import time
from collections.abc import Callable
from typing import Protocol

LEAST_SELECT_S = 0.001
"""The operating system's wait is told in whole milliseconds; what is shorter is slept."""


class HasFileno(Protocol):
    """What can be waited for."""

    def fileno(self) -> int:
        """Descriptor."""
        ...


Waited = int | HasFileno
Callback = Callable[[], None]


class Hub:
    """Calls back whoever has something to read or room to write; blocks no longer than asked."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()

    def watch(self, who: Waited, read: Callback | None, write: Callback | None = None) -> None:
        """Call `read` and `write` when there is something to read, or room; both None: no longer."""
        events = (read is not None) * selectors.EVENT_READ | (write is not None) * selectors.EVENT_WRITE
        known = who in self._selector.get_map()
        if not events:
            if known:
                self._selector.unregister(who)
        elif known:
            self._selector.modify(who, events, (read, write))
        else:
            self._selector.register(who, events, (read, write))

    def wait(self, seconds: float) -> bool:
        """Wait until something has happened, at most `seconds`; returns whether something has.

        Good to about 0.1 ms: the last fraction of a millisecond is slept.
        """
        if seconds >= LEAST_SELECT_S:
            return self._call(int(seconds * 1000.0) / 1000.0)
        if self._call(0.0):
            return True
        if seconds > 0.0:
            time.sleep(seconds)
        return False

    def close(self) -> None:
        """Nobody is waited for any more."""
        self._selector.close()

    def _call(self, timeout_s: float) -> bool:
        ready = self._selector.select(timeout_s)
        for key, events in ready:
            read, write = key.data
            if events & selectors.EVENT_READ and read is not None:
                read()
            if events & selectors.EVENT_WRITE and write is not None and self._still(key, write):
                write()
        return bool(ready)

    def _still(self, key: selectors.SelectorKey, write: Callback) -> bool:
        """Whether `read` has not just ended or changed what is waited for."""
        now = self._selector.get_map().get(key.fd)
        return now is not None and now.data[1] is write
