"""The view in a terminal: fed in small portions, drawn at a fixed rate however much comes."""

from __future__ import annotations

import time

from rich.console import Console
from rich.live import Live

from host.monitor.keys import Keys
from host.monitor.source import Source
from host.monitor.view import MonitorView

FRAMES_A_SECOND = 6
PORTION_S = 0.05
"""Time for the data between two looks at the keyboard."""
IDLE_S = 0.02


def show(console: Console, source: Source, view: MonitorView, for_s: float | None) -> None:
    """Draw until `q`, or until `for_s` of the source's time; Ctrl-C ends it just as well."""
    until_s = float("inf") if for_s is None else for_s
    view.hint = " " + source.hint
    with Keys() as keys, Live(console=console, screen=True, auto_refresh=False) as live:
        drawn_at = 0.0
        while source.now_s < until_s:
            source.pump(view, PORTION_S, until_s)
            now = time.monotonic()
            if now - drawn_at >= 1 / FRAMES_A_SECOND:
                live.update(view.render(*console.size), refresh=True)
                drawn_at = time.monotonic()
            for key in keys.wait(IDLE_S):
                if key in ("q", "Q"):
                    return
                source.press(key, view)
                drawn_at = 0.0
