"""An emulated board, run and looked at: in real time, at a multiple of it, or as fast as it goes."""

from __future__ import annotations

import time
from contextlib import ExitStack, suppress

from host.monitor.pace import Pace
from host.monitor.view import MonitorView
from host.monitor.words import duration
from host.record.errors import UserError
from host.record.result import RunRequest
from host.record.screens import Picture
from host.run.intake import HOST_PORT
from host.run.session import open_session

STEP_NS = 20_000_000
SECOND_NS = 1_000_000_000
PACE_HINT = "q quit   space pause   +/- speed"
KEYS_OF_BOARD = {
    **{arrow: arrow.upper() for arrow in ("up", "down", "left", "right")},
    **dict.fromkeys(("\n", "\r"), "OK"),
    **dict.fromkeys(("\x7f", "\x08"), "BACK"),
}
"""What the keys of a terminal are on the board."""


class BoardSource:
    """Implements `host.monitor.source.Source`."""

    hint = PACE_HINT

    def __init__(self, request: RunRequest, speed: float) -> None:
        """Brings the board up. Raises UserError for whatever the user can mend."""
        self.pace = Pace(speed)
        self._open = ExitStack()
        session = self._open.enter_context(open_session(request))
        self._session = session
        self._ears = session.board.from_board[HOST_PORT].connect_late()
        setup = session.setup
        self.title = f"{setup.board.name} {setup.scenario.name} {setup.profile_name} seed {request.seed}"
        self._end_ns = session.world.duration_ns
        self._panel = session.panel
        if self._panel is not None and self._panel.keys:
            self.hint = f"{PACE_HINT}   arrows, Enter, Backspace: the board's keys"

    @property
    def now_s(self) -> float:
        """Virtual time."""
        return self._session.now_ns / SECOND_NS

    @property
    def ended(self) -> bool:
        """The scenario is over."""
        return self._session.now_ns >= self._end_ns

    def pump(self, view: MonitorView, budget_s: float, until_s: float = float("inf")) -> None:
        """Let virtual time pass as far as it is due."""
        session = self._session
        deadline = time.monotonic() + budget_s
        due_s = min(self.pace.due_s(self.now_s), until_s)
        due_ns = self._end_ns if due_s == float("inf") else min(int(due_s * SECOND_NS), self._end_ns)
        lagging = False
        while session.now_ns < due_ns:
            session.run_until(min(session.now_ns + STEP_NS, due_ns))
            view.feed(self._ears.take()[0], self.now_s)
            if time.monotonic() > deadline:
                lagging = self.pace.speed > 0 and due_ns - session.now_ns > 10 * STEP_NS
                break
        view.time_passes(self.now_s)
        view.display = self._shown()
        end = duration(self._end_ns / SECOND_NS)
        view.source = f"{'end' if self.ended else self.pace.told()} of {end}"
        view.source_style = "yellow" if self.ended or self.pace.paused else "green"
        if lagging:
            view.source += ", cannot keep up"
            view.source_style = "bold red"

    def press(self, key: str, view: MonitorView) -> None:
        """Pause and speed, and the board's own keys."""
        panel = self._panel
        if panel is not None and KEYS_OF_BOARD.get(key) in panel.keys:
            with suppress(UserError):  # it is held still
                panel.press(KEYS_OF_BOARD[key])
        elif key == " ":
            self.pace.paused = not self.pace.paused
        elif key in ("+", "-") and self.pace.speed:
            self.pace.speed = min(max(self.pace.speed * (2.0 if key == "+" else 0.5), 0.125), 1024.0)

    def _shown(self) -> Picture | None:
        """What is to be seen on the board's display, if anything."""
        if self._panel is None or self._panel.display is None:
            return None
        picture = self._panel.picture()
        return picture if picture.any() else None

    def close(self) -> None:
        """Switch the board off."""
        self._open.close()
