"""The runner: one request, one run of virtual time, one result."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from boards.assembly import AssembledBoard, assemble
from boards.places import board_folder
from boards.validation import DescriptionError
from firmware.numerics.subnormals import check_subnormals
from hal.board_io import NotNamedError
from hal.emulated.virtual_time import SECOND
from host.record.errors import UserError
from host.record.manifest import build_manifest
from host.record.recorder import Recorder
from host.record.result import Progress, RunRequest, RunResult
from host.run.faults import Placed, name_of, place_faults
from host.run.garbage import collect_young, undisturbed
from host.run.intake import HOST_PORT, LinkIntake
from host.run.listening import Ears
from host.run.setup import Setup, resolve
from host.run.surroundings import Installation, ReceiverSight, Surroundings
from host.run.usage import bus_use, cpu_use, task_traces
from host.run.warm_up import warm_up
from host.score.expectations import check_names
from host.score.rules import ScoringRules
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import source_text
from host.sim.world import World

CHUNK_NS = 40 * SECOND
"""Virtual time between two looks at what has come over the wires."""
TRACE_AT_NS = 100 * SECOND
RECORDING_RULES = ScoringRules(after_alignment_s=10.0)
"""A recording is a minute long: a minute of grace would leave nothing to score."""


def run(request: RunRequest) -> RunResult:
    """Run a board. Raises UserError for whatever the user can mend."""
    setup, world = _prepared(request)
    manifest = build_manifest(
        setup.board.name,
        (board_folder(request.board) / "board.toml").read_text(encoding="utf-8"),
        setup.scenario.name,
        source_text(setup.scenario.path) if setup.scenario.path else "",
        setup.profile_name,
        request.seed,
        request.overrides,
    )
    return run_in_world(request, setup, world, manifest)


def run_in_world(request: RunRequest, setup: Setup, world: World, manifest: Mapping[str, Any]) -> RunResult:
    """Run a board in a world that is there already; faults are those of the world's scenario."""
    ready = _make_ready(request, setup, world)
    recording = world.scenario.kind == "recording"
    outages = [(w.start_ns / SECOND, (w.end_ns - w.start_ns) / SECOND) for w in world.outages]
    with Recorder(
        manifest,
        request.out_dir,
        capture=request.capture,
        outages=outages,
        rules=RECORDING_RULES if recording else None,
        fit_recording=recording,
    ) as recorder:
        try:
            return _run(request, setup, world, ready, recorder)
        finally:
            ready.surroundings.close()


def _prepared(request: RunRequest) -> tuple[Setup, World]:
    check_subnormals()
    with _user_errors():
        setup = resolve(request)
        scenario = setup.scenario
        source = str(scenario.path or scenario.name)
        check_names(scenario.expect, _parts(setup), source, scenario.kind == "recording")
    _check_host_port(setup)
    with _user_errors():
        world = World(setup.scenario, request.seed, request.data_dir)
    return setup, world


def check(request: RunRequest) -> float:
    """Do all that comes before virtual time, kernels included, and nothing more. Raises UserError.

    Returns how long the run will be, s of virtual time.
    """
    setup, world = _prepared(request)
    _make_ready(request, setup, world).surroundings.close()
    return world.duration_ns / SECOND


@dataclass(frozen=True)
class Ready:
    """A board in its surroundings, with all faults in place; nothing has been written yet."""

    surroundings: Surroundings
    board: AssembledBoard
    faults: list[Placed]


def _make_ready(request: RunRequest, setup: Setup, world: World) -> Ready:
    with _user_errors(f"{board_folder(request.board) / 'board.toml'}: "):
        warm_up(setup, world.another, request.notice)
        surroundings = Surroundings(world, request.out_dir)
        board = assemble(setup.board, setup.profile, surroundings)
        faults = place_faults(
            world.scenario.fault, board, surroundings.sights, request.seed, world.duration_ns
        )
    return Ready(surroundings, board, faults)


def _run(request: RunRequest, setup: Setup, world: World, ready: Ready, recorder: Recorder) -> RunResult:
    board, surroundings = ready.board, ready.surroundings
    intake = LinkIntake(board, world, recorder, _only_sight(surroundings), _installation(setup))
    ears = Ears(board, HOST_PORT, intake.receive, recorder.capture)
    intake.gather = ears.hand_on
    with _user_errors(f"{board_folder(request.board) / 'board.toml'}: "):
        wall_s = _work_off(board, world.duration_ns, intake, request.progress)
    for trace in task_traces(board):
        recorder.add_trace(trace)
    for name, cpu in board.cpus.items():
        for at_ns, cause in cpu.resets:
            recorder.add_event(at_ns, name, f"processor reset: {cause}")
    for refdes, chip in board.chips.items():
        for report in getattr(chip, "reports", ()):
            told = f"{report.kind.value}: {report.register}: {report.detail}, {report.count} times"
            recorder.add_event(report.first_ns, refdes, told)
    duration_ns = world.duration_ns
    return recorder.finish(
        duration_s=duration_ns / SECOND,
        wall_s=wall_s,
        state_hash=ears.hexdigest(),
        cpu=cpu_use(board, duration_ns),
        buses=bus_use(board, duration_ns),
        faults=[placed.use() for placed in ready.faults],
        expect=world.scenario.expect,
        gnss_extra=intake.tags.figures(),
    )


def _work_off(
    board: AssembledBoard, duration_ns: int, intake: LinkIntake, progress: Progress | None
) -> float:
    """Let all virtual time pass; returns the wall-clock seconds it took, generation and scoring included."""
    for cpu in board.cpus.values():
        board.time.at(min(TRACE_AT_NS, duration_ns // 2), lambda cpu=cpu: cpu.start_trace())  # type: ignore[misc]
    with undisturbed():
        begin = time.perf_counter()
        now = 0
        while now < duration_ns:
            now = min(now + CHUNK_NS, duration_ns)
            board.machine.run_until(now)
            intake.flush(now)
            collect_young()
            if progress is not None:
                progress(now / SECOND, duration_ns / SECOND)
        wall_s = time.perf_counter() - begin
    board.machine.power_off()
    return wall_s


def _check_host_port(setup: Setup) -> None:
    """What comes over the UART called "host" is what is scored."""
    if HOST_PORT not in setup.board.uarts:
        known = ", ".join(setup.board.uarts) or "none"
        processor = next(iter(setup.board.processors))
        raise UserError(
            f"board {setup.board.name}: no UART {HOST_PORT!r} for the solution (there is: {known});"
            f' for example [uarts.{HOST_PORT}] processor = "{processor}", baud = 230_400'
        )


def _only_sight(surroundings: Surroundings) -> ReceiverSight | None:
    return next(iter(surroundings.sights.values()), None)


def _installation(setup: Setup) -> Installation:
    chips = setup.board.chips.values()
    imu = next((chip for chip in chips if chip.world == "imu"), None)
    receiver = next((chip for chip in chips if chip.world == "gnss"), None)
    return Installation(
        C_b_s=np.array(imu.mounting) if imu else np.eye(3),
        imu_lever_arm=np.array(imu.lever_arm_m) if imu else np.zeros(3),
        antenna_lever_arm=np.array(receiver.lever_arm_m) if receiver else np.zeros(3),
    )


def _parts(setup: Setup) -> dict[str, list[str]]:
    board = setup.board
    return {
        "cpu": list(board.processors),
        "buses": [
            *board.buses,
            *(f"{name}.{direction}" for name in board.uarts for direction in ("rx", "tx")),
            *board.can,
        ],
        "faults": [name_of(fault) for fault in setup.scenario.fault],
    }


@contextmanager
def _user_errors(source: str = "") -> Iterator[None]:
    """Turn errors of descriptions into the one error that the command line shows without a traceback."""
    try:
        yield
    except (DescriptionError, ScenarioError) as error:
        raise UserError(str(error)) from None
    except NotNamedError as error:
        raise UserError(f"{source}{error}") from None


__all__ = ["Placed", "run"]
