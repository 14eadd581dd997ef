"""A run that is worked off in pieces, by whoever opens it.

    with open_session(request) as session:
        while session.now_ns < session.world.duration_ns:
            session.run_until(session.now_ns + 10_000_000)
        result = session.finish(wall_s)

The board does not depend on the pieces: the state hash of a run in pieces of a millisecond is that of the
same run in one. A session that is left without `finish` leaves its folder marked as not finished, with all
that was recorded. Virtual time may go beyond the scenario's own end: a simulated vehicle keeps on doing what
it did last.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any

from boards.assembly import AssembledBoard
from boards.places import board_folder
from hal.emulated.virtual_time import SECOND
from host.record.manifest import build_manifest
from host.record.recorder import Recorder
from host.record.result import RunRequest, RunResult
from host.run.age_of_data import AgeOfData, sample_tellers
from host.run.faults import Placed
from host.run.garbage import collect_young, undisturbed
from host.run.intake import HOST_PORT, LinkIntake
from host.run.listening import Ears
from host.run.panel import Panel
from host.run.readiness import Ready, StandIn, board_source, make_ready, prepared, user_errors
from host.run.setup import Setup
from host.run.surroundings import Installation, ReceiverSight, Surroundings
from host.run.usage import bus_use, cpu_use, task_traces
from host.score.rules import ScoringRules
from host.sim.scenario.load import source_text
from host.sim.world import World

CHUNK_NS = 120 * SECOND
"""Virtual time after which, at the latest, what has come over the wires is looked at: many rows at a time."""
TRACE_AT_NS = 100 * SECOND
RECORDING_GRACE_S = 10.0
"""A recording is a minute long: a minute of grace would leave nothing to score."""


class RunSession:
    """One run under way. Made by `open_session` or `session_in_world`."""

    def __init__(
        self, request: RunRequest, setup: Setup, world: World, ready: Ready, recorder: Recorder
    ) -> None:
        self.request = request
        self.setup = setup
        self.world = world
        self.recorder = recorder
        self.board: AssembledBoard = ready.board
        self.surroundings: Surroundings = ready.surroundings
        self.faults: list[Placed] = ready.faults
        """Those of the scenario; further ones may be appended as they are placed."""
        self.panel: Panel | None = ready.panel
        """What an operator has before him."""
        board = self.board
        cpu = board.cpus[board.description.uarts[HOST_PORT].processor]
        self._intake = LinkIntake(
            cpu.virtual_ns, world, recorder, _only_sight(ready.surroundings), Installation.of(setup.board)
        )
        cpu.reset_hooks.append(self._intake.flush)  # what has come belongs to the clock that ends here
        self.ears = Ears(board, HOST_PORT, self._intake.receive, recorder.capture)
        self._intake.gather = self.ears.hand_on
        self._ages = AgeOfData(sample_tellers(board.chips), cpu.virtual_ns)
        if self._ages.figures():
            board.from_board[HOST_PORT].attach(self._ages)
        self._looked_ns = 0
        self._source = board_source(request)
        for cpu in board.cpus.values():
            at_ns = min(TRACE_AT_NS, world.duration_ns // 2)
            board.time.at(at_ns, lambda cpu=cpu: cpu.start_trace())  # type: ignore[misc]
        self._collector_waits = ExitStack()
        self._collector_waits.enter_context(undisturbed())

    @property
    def now_ns(self) -> int:
        """Virtual time reached."""
        return self.board.time.now

    def run_until(self, end_ns: int) -> None:
        """Let virtual time pass to `end_ns`. Raises UserError for what the board's description lacks."""
        with user_errors(self._source):
            while self.now_ns < end_ns:
                look_ns = self._looked_ns + CHUNK_NS
                self.board.machine.run_until(min(end_ns, look_ns))
                if self.now_ns == look_ns:
                    self.look()

    def look(self) -> None:
        """Decode and score what has come over the wires by now; takes some milliseconds for a second."""
        if self.now_ns > self._looked_ns:
            self._looked_ns = self.now_ns
            self._intake.flush()
            collect_young()

    def finish(self, wall_s: float, judged: bool = True) -> RunResult:
        """End the run here, score it and write what is left to write.

        Not `judged`: the scenario's expectations are left out.
        """
        self.look()
        self.close()
        board, recorder, duration_ns = self.board, self.recorder, self.now_ns
        for trace in task_traces(board):
            recorder.add_trace(trace)
        for course in self.ears.can_courses(duration_ns):
            recorder.add_can_course(course)
        for name, cpu in board.cpus.items():
            for at_ns, cause in cpu.resets:
                recorder.add_event(at_ns, name, f"processor reset: {cause}")
        for refdes, chip in board.chips.items():
            for report in getattr(chip, "reports", ()):
                told = f"{report.kind.value}: {report.register}: {report.detail}, {report.count} times"
                recorder.add_event(report.first_ns, refdes, told)
        for screen in self.panel.screens if self.panel is not None else ():
            recorder.add_screen(screen)
        return recorder.finish(
            duration_s=duration_ns / SECOND,
            wall_s=wall_s,
            state_hash=self.ears.hexdigest(),
            cpu=cpu_use(board, max(1, duration_ns)),
            buses=bus_use(board, max(1, duration_ns)),
            faults=[placed.use() for placed in self.faults],
            expect=self.world.scenario.expect if judged else None,
            gnss_extra=self._intake.tags.figures(),
            metrics_extra=self._ages.figures(),
        )

    def close(self) -> None:
        """Switch the board off; harmless the second time."""
        self._collector_waits.close()
        self.board.machine.power_off()


@contextmanager
def open_session(request: RunRequest, stand_ins: Mapping[str, StandIn] | None = None) -> Iterator[RunSession]:
    """A session in the world of the scenario; `stand_ins` take the places of chips, by reference designator.

    Raises UserError for whatever the user can mend, before anything is written.
    """
    setup, world = prepared(request)
    manifest = manifest_of(request, setup)
    if stand_ins:
        manifest["stand_ins"] = {refdes: other.model for refdes, other in stand_ins.items()}
    with session_in_world(request, setup, world, manifest, stand_ins) as session:
        yield session


@contextmanager
def session_in_world(
    request: RunRequest,
    setup: Setup,
    world: World,
    manifest: Mapping[str, Any],
    stand_ins: Mapping[str, StandIn] | None = None,
) -> Iterator[RunSession]:
    """A session in a world that is there already; faults are those of the world's scenario."""
    ready = make_ready(request, setup, world, stand_ins)
    recording = world.scenario.kind == "recording"
    outages = [(w.start_ns / SECOND, (w.end_ns - w.start_ns) / SECOND) for w in world.outages]
    with Recorder(
        manifest,
        request.out_dir,
        capture=request.capture,
        outages=outages,
        rules=_rules(setup, recording),
        fit_recording=recording,
    ) as recorder:
        session = RunSession(request, setup, world, ready, recorder)
        try:
            yield session
        finally:
            session.close()
            ready.surroundings.close()


def manifest_of(request: RunRequest, setup: Setup) -> dict[str, Any]:
    """The manifest of a run from the texts of board and scenario."""
    return build_manifest(
        setup.board.name,
        (board_folder(request.board) / "board.toml").read_text(encoding="utf-8"),
        setup.scenario.name,
        source_text(setup.scenario.path) if setup.scenario.path else "",
        setup.profile_name,
        request.seed,
        request.overrides,
    )


def _rules(setup: Setup, recording: bool) -> ScoringRules:
    usual = ScoringRules()
    return ScoringRules(
        after_alignment_s=RECORDING_GRACE_S if recording else usual.after_alignment_s,
        at_receiver_epochs=any(chip.world == "gnss" for chip in setup.board.chips.values()),
    )


def _only_sight(surroundings: Surroundings) -> ReceiverSight | None:
    return next(iter(surroundings.sights.values()), None)
