"""Serves one board: opens its places, lets time pass at a pace, and ends cleanly.

with opened(request, places) as service:
    result = service.serve()
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

from boards.description import Board
from hal.can import CanFrame
from host.record.errors import UserError
from host.record.result import RunRequest, RunResult
from host.replay.control_tape import text_of_frame
from host.run.readiness import user_errors
from host.run.session import RunSession, open_session
from host.run.setup import resolve
from host.serve.address import Address, check_local
from host.serve.can_adapter import CanAdapter
from host.serve.can_line import CanLine
from host.serve.commands import Commands, check_pace
from host.serve.control import ControlChannel
from host.serve.endpoint import Tell, Terms
from host.serve.hub import Hub
from host.serve.pacing import FAST_SLICE_NS, SLICE_S, PacedRun
from host.serve.places import can_places, uart_endpoints
from host.serve.status import status_of
from host.serve.uart_line import UartLine

FINISH_WAIT_S = 0.01
FINISH_S = 2.0
"""At a pace nobody waits longer than this for clients to take the end."""


@dataclass(frozen=True)
class Wanted:
    """What is to be served, and how."""

    uarts: Sequence[str] = ()
    """NAME=URL each, as in `host.serve.places`."""
    cans: Sequence[str] = ()
    """[NAME=]INTERFACE:CHANNEL each."""
    pace: float = 1.0
    control: Address | None = None
    paused: bool = False
    """Begin paused: the control channel resumes."""
    allow_remote: bool = False
    stall_s: float = 10.0
    tell: Tell = field(default=lambda _line: None)
    look_around: Callable[[Service], None] = field(default=lambda _service: None)
    """Called about once a second."""


class OpenPlaces:
    """The places of one board, there for clients before the board itself is: they may be taken or missing.

    Lines for people go to `tell`, and are kept in `said` for the capture.
    """

    def __init__(self, wanted: Wanted, board: Board, closing: ExitStack) -> None:
        """Raises UserError; what was opened is closed by `closing`."""
        self.hub = Hub()
        closing.callback(self.hub.close)
        self.said: list[str] = []
        self.terms: list[Terms] = []
        self._wanted = wanted
        self.uarts = uart_endpoints(wanted.uarts, board, wanted.allow_remote)
        self.uart_terms = {name: self._new_terms() for name in self.uarts}
        cans = can_places(wanted.cans, board)
        for name, endpoint in self.uarts.items():
            endpoint.open(self.hub, self.uart_terms[name])
            closing.callback(endpoint.close)
        self.control: ControlChannel | None = None
        if wanted.control is not None:
            self.control = ControlChannel(wanted.control, self.hub, self._new_terms())
            closing.callback(self.control.close)
        self.cans: dict[str, CanAdapter] = {}
        for place in cans:
            self.cans[place.bus] = CanAdapter(place, board.can[place.bus].bitrate, self._new_terms())
            closing.callback(self.cans[place.bus].close)

    def tell(self, line: str) -> None:
        """To people, and into the capture as soon as there is one."""
        self._wanted.tell(line)
        self.said.append(line)

    def _new_terms(self) -> Terms:
        terms = Terms(self.tell, self._wanted.stall_s, not self._wanted.pace)
        self.terms.append(terms)
        return terms


class Service:
    """A board and its places. Implements `host.serve.pacing.Outside`."""

    def __init__(self, session: RunSession, wanted: Wanted, places: OpenPlaces) -> None:
        self.session = session
        self.wanted = wanted
        self.paced = PacedRun(session, self, wanted.pace)
        self.commands = Commands(session, self.paced, lambda: status_of(self))
        self._places = places
        self._in_a_hurry = False
        board = session.board
        self.uarts = [UartLine(board, name, endpoint) for name, endpoint in places.uarts.items()]
        for line in self.uarts:
            places.uart_terms[line.name].line_baud = lambda line=line: line.baud
            places.tell(f"UART {line.name}, {line.leads_to}: {line.endpoint.where}")
        self.cans = []
        for name, adapter in places.cans.items():
            self.commands.log("serve-can", {"bus": name})
            self.cans.append(CanLine(board.can_buses[name], adapter, self._log_frames))
            places.tell(f"CAN {name}: {adapter.where}")
        self._control = places.control
        if self._control is not None:
            places.tell(f"control: {self._control.where}")
        if wanted.paused:
            self.paced.pause()

    def serve(self) -> RunResult:
        """Let time pass to the end of the scenario, or until somebody stops it; the result.

        What was stopped in the middle cannot be held to what is expected of the whole: it is not judged.
        """
        self.paced.run(self.session.world.duration_ns)
        self._hand_over_the_rest()
        return self.session.finish(self.paced.running_s, judged=not self.paced.stopped)

    def stop(self) -> None:
        """End soon; asked a second time, without waiting for anybody. May be called by a signal."""
        self._in_a_hurry = self.paced.stopped
        self.paced.stop()

    # -- host.serve.pacing.Outside -----------------------------------------------------------------

    def bring_in(self) -> None:
        """What has come from outside goes onto the board's wires."""
        pace = self.paced.pace
        slice_ns = round(2 * SLICE_S * 1e9 * pace) if pace else FAST_SLICE_NS
        for line in self.uarts:
            line.bring_in(slice_ns)
        for can in self.cans:
            can.bring_in()

    def hand_out(self) -> None:
        """What the board has sent goes outside."""
        for line in self.uarts:
            line.hand_out()
        for can in self.cans:
            can.hand_out()

    def wait(self, seconds: float) -> None:
        """Wait for clients and commands."""
        lossless = not self.paced.pace
        for terms in self._places.terms:
            terms.lossless = lossless
        self._places.hub.wait(seconds)
        for line in self.uarts:
            line.endpoint.attend()
        if self._control is not None:
            self._control.attend(self.commands.do)
        self._note_what_was_said()

    def holds_up(self) -> bool:
        """Whether somebody who reads has not been given everything."""
        return any(line.endpoint.backlog for line in self.uarts) or any(
            can.adapter.holds_up for can in self.cans
        )

    def look_around(self) -> None:
        """Show how it goes."""
        self.wanted.look_around(self)

    # ----------------------------------------------------------------------------------------------

    def _hand_over_the_rest(self) -> None:
        """Whoever reads gets everything; whoever does not is waited for no longer than is said."""
        until = time.monotonic() + (
            min(FINISH_S, self.wanted.stall_s) if self.paced.pace else self.wanted.stall_s
        )
        while time.monotonic() < until and not self._in_a_hurry:
            finished = [line.endpoint.finish() for line in self.uarts]
            if all(finished):
                break
            self._places.hub.wait(FINISH_WAIT_S)
        for line in self.uarts:
            if line.endpoint.backlog:
                self._places.tell(f"UART {line.name}: a client that did not read misses the end")
        for can in self.cans:
            can.adapter.finish()
        self._note_what_was_said()

    def _note_what_was_said(self) -> None:
        said, self._places.said = self._places.said, []
        for line in said:
            self.session.recorder.add_event(self.session.now_ns, "serve", line)

    def _log_frames(self, bus: str, frames: Sequence[CanFrame]) -> None:
        self.commands.log("can-frames", {"bus": bus, "frames": [text_of_frame(frame) for frame in frames]})


@contextmanager
def opened(request: RunRequest, wanted: Wanted) -> Iterator[Service]:
    """A board that is there for its clients. Raises UserError for whatever the user can mend."""
    check_pace(wanted.pace, "--pace")
    if wanted.paused and wanted.control is None:
        raise UserError("--paused: nobody could resume; give a control channel too, --control 127.0.0.1:5761")
    if wanted.control is not None:
        check_local(wanted.control, "--control", wanted.allow_remote)
    with user_errors():
        board = resolve(request).board
    with ExitStack() as closing:
        places = OpenPlaces(wanted, board, closing)
        yield Service(closing.enter_context(open_session(request)), wanted, places)


def figures_of(service: Service) -> dict[str, Any]:
    """For `--json`: how it was served."""
    return status_of(service) | {"histogram": service.paced.lateness.histogram()}
