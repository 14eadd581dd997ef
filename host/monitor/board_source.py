"""An emulated board, run and looked at: in real time, at a multiple of it, or as fast as it goes."""

from __future__ import annotations

import time
from contextlib import ExitStack

from host.monitor.pace import Pace
from host.monitor.view import MonitorView
from host.monitor.words import duration
from host.record.result import RunRequest
from host.run.intake import HOST_PORT
from host.run.session import open_session

STEP_NS = 20_000_000
SECOND_NS = 1_000_000_000


class BoardSource:
    """Implements `host.monitor.source.Source`."""

    hint = "q quit   space pause   +/- speed"

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
        end = duration(self._end_ns / SECOND_NS)
        view.source = f"{'end' if self.ended else self.pace.told()} of {end}"
        view.source_style = "yellow" if self.ended or self.pace.paused else "green"
        if lagging:
            view.source += ", cannot keep up"
            view.source_style = "bold red"

    def press(self, key: str, view: MonitorView) -> None:
        """Pause and speed."""
        if key == " ":
            self.pace.paused = not self.pace.paused
        elif key in ("+", "-") and self.pace.speed:
            self.pace.speed = min(max(self.pace.speed * (2.0 if key == "+" else 0.5), 0.125), 1024.0)

    def close(self) -> None:
        """Switch the board off."""
        self._open.close()
