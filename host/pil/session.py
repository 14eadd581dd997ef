"""One comparison of a twin with a processor, from the request to its result."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, field
from typing import Any

from boards.description import load_board
from firmware.link.stand_alone import StandAlone
from firmware.numerics.dialect import entries_observed
from hal.emulated.virtual_time import SECOND
from host.pil.board_kernels import ALL, NAVIGATION, kernels_of
from host.pil.image import LARGEST_IMAGE, Image, build_image
from host.pil.kernel_table import TargetKernel
from host.pil.lockstep import Counts, Lockstep
from host.pil.monitor_link import MonitorLink, open_port
from host.pil.navigation_parts import parts_after, ticks_of_parts
from host.pil.qemu import emulated_board, instructions
from host.pil.stand_alone import kernel_name, stand_alone_of
from host.pil.toolchain import COMPILER, EMULATOR, check_tools
from host.pil.unit_trials import run_trials, unit_kernels
from host.record.result import RunRequest
from host.run.readiness import make_ready, prepared, user_errors
from host.run.setup import Setup
from host.sim.world import World

CHUNK_NS = SECOND // 4
FORMAT = "navtwin-pil-1"
NO_LIMIT = 1 << 62


@dataclass(frozen=True, slots=True)
class PilRequest:
    """What to compare."""

    run: RunRequest
    steps: int
    port: str | None = None
    """Of a board; None: an emulated one is started."""
    counting: bool = False
    """The emulated processor counts instructions (slower)."""
    planted: str | None = None
    unit: bool = False
    """Each kernel on its own instead of the twin's run; `steps` is then no limit."""

    @property
    def counts_parts(self) -> bool:
        """Whether inner kernels are counted, which a flashed image does not hold."""
        return self.counting and self.port is None and not self.unit

    @property
    def flash_limit(self) -> int | None:
        """Bytes of the image; None for one that no board flashes, which holds more."""
        return None if self.unit or self.counts_parts else LARGEST_IMAGE


@dataclass(slots=True)
class PilResult:
    """What came of it; `to_dict` is what --json writes."""

    board: str
    profile: str
    scenario: str
    seed: int
    target: str
    identity: str
    image_bytes: int
    steps: int
    virtual_s: float
    wall_s: float
    first_difference: dict[str, Any] | None
    differences: int
    """Steps that differ; the work ends at the tenth."""
    kernels: dict[str, int]
    """Steps of each."""
    cycles: dict[str, dict[str, float]] = field(default_factory=dict)
    """Mean, least and most of each kernel: instructions when counting, core cycles of a real board."""
    cycles_are: str | None = None
    parts: dict[str, int] = field(default_factory=dict)
    """Instructions of the parts of a navigation step, when counting."""
    line: dict[str, int] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    planted: str | None = None
    left_out: dict[str, str] = field(default_factory=dict)
    """Kernels that were not tried on their own, and why."""

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {"format": FORMAT, **asdict(self)}


def image_of(request: RunRequest, as_asked: bool = False) -> Image:
    """The image of a board and profile, as a board flashes it. Raises UserError.

    `as_asked`: its own loop is configured as scenario and --set of the request say, not as the board's
    profile alone.
    """
    setup, world = prepared(request)
    with user_errors():
        loop = stand_alone_of(setup.board, setup.profile) if as_asked else _own_loop(request.board, setup)
        return build_image(kernels_of(setup, world.another()), None, LARGEST_IMAGE, loop)


def _own_loop(name: str, setup: Setup) -> StandAlone | None:
    """The loop of a board's profile, whatever scenario and options change: what `navtwin build` flashes."""
    board = load_board(name)
    return stand_alone_of(board, board.profiles[setup.profile_name])


def compare(request: PilRequest, notice: Callable[[str], None]) -> PilResult:
    """Run twin and processor beside each other. Raises UserError for what the user can mend."""
    setup, world = prepared(request.run)
    check_tools(COMPILER, *([EMULATOR] if request.port is None else []))
    kernels, loop = _kernels(request, setup, world)
    notice("building the image (a minute when the kernels are new) …")
    image = build_image(kernels, request.planted, request.flash_limit, loop)
    with _processor(image, request) as name:
        port = open_port(name)
        try:
            link = MonitorLink(port, name)
            greeting = link.greet(image.identity)
            limit = NO_LIMIT if request.unit else request.steps
            lockstep = Lockstep(link, image, greeting.memory, limit)
            begin, reached_ns, left_out, parts = time.perf_counter(), 0, {}, {}
            if request.unit:
                left_out = run_trials(lockstep, notice)
            else:
                reached_ns = _run_twin(request, setup, world, lockstep)
            if request.counts_parts and loop is not None and lockstep.compared:
                state = lockstep.latest[kernel_name(loop.sample)]
                parts = ticks_of_parts(Lockstep(link, image, greeting.memory, NO_LIMIT), state)
            wall_s = time.perf_counter() - begin
        finally:
            port.close()
    result = PilResult(
        board=setup.board.name,
        profile=setup.profile_name,
        scenario=setup.scenario.name,
        seed=request.run.seed,
        target="QEMU netduinoplus2" if request.port is None else request.port,
        identity=image.identity,
        image_bytes=image.size,
        steps=lockstep.compared,
        virtual_s=reached_ns / SECOND,
        wall_s=wall_s,
        differences=len(lockstep.differences),
        first_difference=asdict(lockstep.differences[0]) if lockstep.differences else None,
        kernels={name: counts.calls for name, counts in sorted(lockstep.counts.items())},
        line=asdict(link.trouble),
        versions=image.versions,
        planted=request.planted,
        left_out=left_out,
    )
    if request.port is not None or request.counting:
        result.cycles_are = "cycles" if request.port is not None else "instructions"
        result.cycles = {
            name: _figures(counts, request.port is None) for name, counts in sorted(lockstep.counts.items())
        }
        result.parts = {name: instructions(ticks) for name, ticks in parts.items()}
    return result


def _kernels(request: PilRequest, setup: Setup, world: World) -> tuple[list[TargetKernel], StandAlone | None]:
    """What the image holds. Costs and single kernels are of parsers and frames, too."""
    with user_errors():
        loop = None if request.unit else _own_loop(request.run.board, setup)
        wanted = ALL if request.unit or request.counts_parts else NAVIGATION
        kernels = kernels_of(setup, world.another(), wanted)
    if request.unit:
        return unit_kernels(kernels), None
    if request.counts_parts and loop is not None:
        kernels += parts_after(len(kernels))
    return kernels, loop


@contextmanager
def _processor(image: Image, request: PilRequest) -> Iterator[str]:
    """Name of the port behind which the image runs."""
    emulated = emulated_board(image.file("elf"), request.counting) if request.port is None else None
    with emulated or nullcontext(request.port) as name:
        assert name is not None
        yield name


def _run_twin(request: PilRequest, setup: Setup, world: World, lockstep: Lockstep) -> int:
    """Let the twin's firmware run until enough was compared or its scenario ends; returns virtual time."""
    with entries_observed(lockstep.observe):
        ready = make_ready(request.run, setup, world)
        machine = ready.board.machine
        try:
            with user_errors():
                while not lockstep.is_over and ready.board.time.now < world.duration_ns:
                    machine.run_until(min(ready.board.time.now + CHUNK_NS, world.duration_ns))
        finally:
            machine.power_off()
            ready.surroundings.close()
        lockstep.flush()
        return ready.board.time.now


def _figures(counts: Counts, emulated: bool) -> dict[str, float]:
    unit = instructions if emulated else round
    return {
        "mean": unit(counts.total / counts.calls),
        "least": unit(counts.least),
        "most": unit(counts.most),
    }
