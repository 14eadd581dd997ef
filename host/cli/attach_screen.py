"""The live view of what is attached, or lines where there is no terminal for it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.live import Live

from host.cli.terminal import standard_error
from host.link.decoder import LinkDecoder
from host.link.messages import Message
from host.monitor.view import MonitorView

REFRESH_S = 0.2


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

    def show(self, messages: list[tuple[int, Message]], at_s: float) -> None:
        """Messages that have come."""
        view = self._view
        if view is None or self._live is None:
            return
        view.take(messages, at_s)
        view.source = self._last
        now = time.monotonic()
        if now - self._drawn >= REFRESH_S:
            self._drawn = now
            size = self._console.size
            self._live.update(view.render(size.width, size.height), refresh=True)

    def notice(self, text: str) -> None:
        """Something people should know."""
        self._last = text
        if self._view is not None:
            self._view.say(text)
        elif not self._quiet:
            self._console.print(text, soft_wrap=True, markup=False)


@contextmanager
def screen(title: str, quiet: bool) -> Iterator[Screen]:
    """The whole terminal, given back at the end; lines where standard error is none, nothing when quiet."""
    console = standard_error()
    if quiet or not console.is_terminal or console.is_dumb_terminal:
        yield Screen(console, None, title, quiet)
        return
    with Live(console=console, screen=True, auto_refresh=False) as live:
        yield Screen(console, live, title, quiet)
