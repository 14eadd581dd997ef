"""The view for those who cannot see a terminal: JSON lines, or one picture as text."""

from __future__ import annotations

import time
from collections.abc import Callable

from host.monitor.figures import figures_line
from host.monitor.source import Source
from host.monitor.view import MonitorView

PORTION_S = 0.1
IDLE_S = 0.02
EACH_S = 1.0


def stream(source: Source, view: MonitorView, for_s: float | None, write: Callable[[str], None]) -> None:
    """A line of JSON for each second of the source's time, and one at its end."""
    until_s = float("inf") if for_s is None else for_s
    next_s = (source.now_s // EACH_S + 1) * EACH_S
    while not source.ended and source.now_s < until_s:
        _pump_to(source, view, min(next_s, until_s))
        write(figures_line(view))
        next_s = max(next_s + EACH_S, (source.now_s // EACH_S) * EACH_S)


def listen(source: Source, view: MonitorView, for_s: float) -> None:
    """Take in the source up to `for_s` of its time."""
    _pump_to(source, view, for_s)


def _pump_to(source: Source, view: MonitorView, until_s: float) -> None:
    while not source.ended and source.now_s < until_s:
        before = source.now_s
        began = time.monotonic()
        source.pump(view, PORTION_S, until_s)
        if time.monotonic() - began < PORTION_S and source.now_s - before < PORTION_S:
            time.sleep(IDLE_S)
