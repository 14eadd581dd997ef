"""Single keys from the terminal, without waiting; the terminal is left as it was found."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import time
from types import TracebackType
from typing import Any, Self

ARROWS = {b"[A": "up", b"[B": "down", b"[C": "right", b"[D": "left"}


class Keys:
    """A context in which keys come one at a time. Without a terminal none ever come."""

    def __init__(self) -> None:
        self._descriptor: int | None = None
        self._before: list[Any] = []

    def __enter__(self) -> Self:
        try:
            import termios
            import tty

            descriptor = sys.stdin.fileno()
            if os.isatty(descriptor):
                self._before = termios.tcgetattr(descriptor)
                tty.setcbreak(descriptor)
                self._descriptor = descriptor
        except (ImportError, OSError, ValueError, AttributeError):
            self._descriptor = None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._descriptor is not None:
            import termios

            with contextlib.suppress(termios.error):
                termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def wait(self, seconds: float) -> list[str]:
        """Keys pressed within `seconds`, sooner back when there are some: signs, "left", "right", …"""
        if self._descriptor is None:
            time.sleep(seconds)
            return []
        ready, _, _ = select.select([self._descriptor], [], [], seconds)
        if not ready:
            return []
        data = os.read(self._descriptor, 64)
        if not data:  # the terminal has gone
            self._descriptor = None
        return _named(data)


def _named(data: bytes) -> list[str]:
    keys = []
    place = 0
    while place < len(data):
        if data[place : place + 1] == b"\x1b":
            name = ARROWS.get(data[place + 1 : place + 3])
            if name is not None:
                keys.append(name)
            place += 3
        else:
            keys.append(chr(data[place]))
            place += 1
    return keys
