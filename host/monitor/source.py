"""Where a view's data come from: what the three kinds of source have in common."""

from __future__ import annotations

from typing import Protocol

from host.monitor.view import MonitorView


class Source(Protocol):
    """A port, a capture or a board. `close` may be called at any time, more than once."""

    title: str
    hint: str
    """Keys that it understands."""

    @property
    def now_s(self) -> float:
        """Time of the source: since the port was opened, or of the run that is played."""
        ...

    @property
    def ended(self) -> bool:
        """Nothing more will come."""
        ...

    def pump(self, view: MonitorView, budget_s: float, until_s: float = float("inf")) -> None:
        """Hand over what is due by now, nothing behind `until_s` of the source's time; take about
        `budget_s` of the wall's time for it and leave the rest for the next call. Tells how it is in
        `view.source`."""
        ...

    def press(self, key: str, view: MonitorView) -> None:
        """A key of `host.monitor.keys` that is none of the view's own."""
        ...

    def close(self) -> None:
        """Let go of everything."""
        ...
