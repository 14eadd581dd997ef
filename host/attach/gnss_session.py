"""A real receiver in the emulated one's place: the board runs in real time on what comes from the port."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from boards.description import Board
from boards.hints import did_you_mean
from firmware.drivers import gnss_epoch as epoch
from firmware.link.frames import GNSS, PAYLOADS, SOLUTION, TEXT
from host.attach.epoch_arrival import EpochArrivals
from host.attach.live_receiver import MODEL, ReceiverLine
from host.attach.receiver_port import ReceiverPort
from host.attach.scatter import MEANING, Scatter
from host.link.decoder import LinkDecoder, open_payload
from host.link.messages import Gnss, Message, Solution
from host.record.errors import UserError
from host.record.result import RunRequest, RunResult
from host.record.run_data import NAVIGATING
from host.run.intake import HOST_PORT
from host.run.readiness import StandIn
from host.run.session import RunSession, open_session
from host.run.setup import Setup, resolve, scenario_names
from host.serve.pacing import SLICE_S, PacedRun
from host.sim.scenario.schema import Scenario
from host.sim.world import World

STANDING = "static"
"""Name of the scenario in which a board's vehicle stands."""
LOOKS = 200
SLOWEST_MPS = 0.05
LONGEST_S = 1e7
SLICE_NS = round(SLICE_S * 1e9)

Show = Callable[[list[tuple[int, Message]], float, int], None]
Notice = Callable[[str], None]


@dataclass(frozen=True)
class GnssAttachment:
    """What came of it."""

    result: RunResult
    figures: dict[str, Any]
    epochs_used: int
    scored: bool


class GnssSession:
    """Implements `host.serve.pacing.Outside` for one receiver."""

    def __init__(
        self,
        session: RunSession,
        refdes: str,
        port: ReceiverPort,
        record_only: bool,
        show: Show,
        notice: Notice,
    ) -> None:
        self.session = session
        self.paced = PacedRun(session, self, 1.0)
        self.line = ReceiverLine(session.board, refdes, port)
        self.arrivals = EpochArrivals()
        self.decoder = LinkDecoder()
        self.epochs_used = 0
        """Epochs with a position that the board took from the receiver."""
        self.receiver_scatter = Scatter()
        self.solution_scatter = Scatter()
        self._port = port
        self._came: deque[tuple[int, bytes]] = deque()
        """What has come, with time.monotonic_ns(); a run that is late takes it when its time has come."""
        self._record_only = record_only
        self._show = show
        self._notice = notice
        self._ear = session.board.from_board[HOST_PORT].connect_late()

    def run(self) -> GnssAttachment:
        """To the end of the scenario, or until `stop`."""
        self._port.take()
        self.paced.run(self.session.world.duration_ns)
        self.look_around()
        return GnssAttachment(
            self.session.finish(self.paced.running_s), self.figures(), self.epochs_used, not self._record_only
        )

    def stop(self) -> None:
        """End soon; from a signal."""
        self.paced.stop()

    # -- host.serve.pacing.Outside -----------------------------------------------------------------

    def bring_in(self) -> None:
        """What the receiver has said."""
        self._came.extend(self._port.take())
        if not self._came:
            self.arrivals.take(time.monotonic_ns(), b"")
        until_ns = self.session.now_ns + SLICE_NS
        due: list[tuple[int, bytes]] = []
        while self._came and self.paced.virtual_at(self._came[0][0]) <= until_ns:
            came_ns, data = self._came.popleft()
            self.arrivals.take(came_ns, data)
            due.append((self.paced.virtual_at(came_ns), data))
        self.line.bring_in(due)

    def hand_out(self) -> None:
        """What the board's driver says to it."""
        self.line.hand_out()

    def wait(self, seconds: float) -> None:
        """Bytes gather by themselves meanwhile."""
        time.sleep(seconds)

    def holds_up(self) -> bool:
        """A receiver waits for nobody."""
        return False

    def look_around(self) -> None:
        """About once a second: what the board says, and how the port is."""
        while self._port.notes:
            text = self._port.notes.popleft()
            self._notice(text)
            self.session.recorder.add_event(self.session.now_ns, "attach", text)
        data, _errors = self._ear.take()
        messages: list[tuple[int, Message]] = []
        for kind, payload in self.decoder.feed_raw(data):
            if kind in (SOLUTION, GNSS) and len(payload) == PAYLOADS[kind].size:
                self._take(payload, kind)
            elif kind == TEXT:
                self._notice(f"board: {payload.decode(errors='replace')}")
            message = open_payload(kind, payload)
            if message is not None:
                messages.append((kind, message))
        self._show(messages, self.session.now_ns / 1e9, len(data))

    def _take(self, payload: bytes, kind: int) -> None:
        values = PAYLOADS[kind].unpack(payload)
        if kind == GNSS:
            gnss = Gnss(*values)
            if gnss.flags & epoch.HAS_POSITION:
                self.epochs_used += 1
                self.receiver_scatter.add(gnss.lat_nanodeg, gnss.lon_nanodeg, gnss.height_mm / 1000)
        else:
            solution = Solution(*values)
            if solution.mode >= NAVIGATING:
                self.solution_scatter.add(solution.lat_nanodeg, solution.lon_nanodeg, solution.height)

    # ----------------------------------------------------------------------------------------------

    def figures(self) -> dict[str, Any]:
        """For `--json`; the keys are stable."""
        line, counters, paced = self.line, self._port.link.counters, self.paced
        mean_ms = line.forward_ns / line.forwarded / 1e6 if line.forwarded else None
        scatter = {
            "meaning": MEANING,
            "receiver": self.receiver_scatter.figures(),
            "solution": self.solution_scatter.figures(),
        }
        return {
            "port": self._port.url,
            "baud": self._port.baud,
            "rate_changes": line.rate_changes,
            "bytes_from_receiver": line.bytes_in,
            "bytes_dropped": line.bytes_dropped,
            "bytes_to_receiver": line.bytes_out,
            "port_losses": counters.losses,
            "port_reopenings": counters.reopenings,
            "epochs_used": self.epochs_used,
            "latency": self.arrivals.figures(),
            "forwarding": {
                "mean_ms": mean_ms,
                "max_ms": line.longest_forward_ns / 1e6 if line.forwarded else None,
                "method": "from the arrival at the port to the board's line, in virtual time",
            },
            "pacing": {"slips": paced.slips, "slipped_s": paced.slipped_s},
            "scatter": None if self._record_only else scatter,
        }


@contextmanager
def opened(
    request: RunRequest, setup: Setup, port: ReceiverPort, record_only: bool, show: Show, notice: Notice
) -> Iterator[GnssSession]:
    """The board with the receiver at its UART, not yet running. Raises UserError."""
    refdes = receiver_of(setup.board)
    pins = tuple(setup.board.chips[refdes].pins)
    stand_ins = {refdes: StandIn(MODEL, {"pin_names": pins})}
    with open_session(request, stand_ins) as session:
        yield GnssSession(session, refdes, port, record_only, show, notice)


def receiver_of(board: Board) -> str:
    """The chip whose place is taken. Raises UserError."""
    for refdes, chip in board.chips.items():
        if chip.world == "gnss" and chip.uart is not None:
            return refdes
    raise UserError(f"board {board.name}: it has no GNSS receiver on a UART")


def standing_request(request: RunRequest, record_only: bool) -> RunRequest:
    """The request with its scenario. Raises UserError for one in which the vehicle moves."""
    if request.scenario is None:
        names = scenario_names(request.board)
        if STANDING not in names:
            hint = did_you_mean(STANDING, names)
            raise UserError(
                f"board {request.board}: it has no scenario {STANDING!r}; name one in which its vehicle"
                f" stands, --scenario; {hint}"
            )
        return replace(request, scenario=STANDING)
    setup = resolve(request)
    if not record_only and moves(setup.scenario, request):
        raise UserError(
            f"--scenario {request.scenario}: its vehicle moves, but the receiver at the port stands on a"
            " desk: the inertial sensor would feel a drive that the receiver knows nothing of. Leave it out"
            " (the twin then stands where the receiver is), or --record-only to record without judging"
        )
    return request


def moves(scenario: Scenario, request: RunRequest) -> bool:
    """Whether the vehicle of a scenario ever leaves its place."""
    if scenario.kind == "recording":
        return True
    world = World(scenario, request.seed, request.data_dir)
    times_ns = np.unique(np.linspace(0, world.duration_ns, LOOKS).astype(np.int64))
    return bool(np.abs(world.truth(times_ns).v_ned).max() > SLOWEST_MPS)


def pulse_changes(board: Board) -> tuple[str, ...]:
    """A serial port brings no TIMEPULSE: its capture pins are not wired."""
    nets = set(board.chips[receiver_of(board)].pins.values())
    return tuple(
        f"board.pins.{name}.wired=false"
        for name, pin in board.pins.items()
        if pin.use == "capture" and pin.net in nets and pin.wired
    )
