"""The live view of what is attached, or lines where there is no terminal for it."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Protocol

from rich.console import Console
from rich.live import Live

from host.cli.terminal import standard_error
from host.link.decoder import LinkDecoder
from host.link.messages import Message
from host.monitor.view import MonitorView

REFRESH_S = 0.2
OF_THE_BOARD = "board: "
"""Notices that begin so are TEXT frames, which the view tells by itself."""


class Screen:
    """`begin` it with the decoder whose counts are shown."""

    def __init__(self, console: Console, live: Live | None, title: str, quiet: bool) -> None:
        self._console = console
        self._live = live
        self._quiet = quiet
        self._drawn = 0.0
        self._view: MonitorView | None = None
        self._title = title
        self._last = ""

    def begin(self, decoder: LinkDecoder) -> None:
        """What is shown comes from here on."""
        if self._live is not None:
            self._view = MonitorView(self._title, decoder)
            self._view.hint = "Ctrl-C ends"

    def show(self, messages: list[tuple[int, Message]], at_s: float, size: int) -> None:
        """Messages that have come, in `size` bytes."""
        view = self._view
        if view is None or self._live is None:
            return
        view.link.bytes += size
        view.take(messages, at_s)
        view.source = self._last
        now = time.monotonic()
        if now - self._drawn >= REFRESH_S:
            self._drawn = now
            width, height = self._console.size
            self._live.update(view.render(width, height), refresh=True)

    def notice(self, text: str) -> None:
        """Something people should know."""
        self._last = text
        if self._view is not None:
            if not text.startswith(OF_THE_BOARD):
                self._view.say(text)
        elif not self._quiet:
            self._console.print(text, soft_wrap=True, markup=False)


class Stoppable(Protocol):
    """What a signal ends."""

    def stop(self) -> None:
        """Come to the end soon."""
        ...


@contextmanager
def ended_by_signals(session: Stoppable) -> Iterator[None]:
    """Ctrl-C and SIGTERM end an attachment as its own end does."""

    def stop(_signal: int, _frame: FrameType | None) -> None:
        session.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def screen(title: str, quiet: bool) -> Iterator[Screen]:
    """The whole terminal, given back at the end; lines where standard error is none, nothing when quiet."""
    console = standard_error()
    if quiet or not console.is_terminal or console.is_dumb_terminal:
        yield Screen(console, None, title, quiet)
        return
    with Live(console=console, screen=True, auto_refresh=False) as live:
        yield Screen(console, live, title, quiet)
