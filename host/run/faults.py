"""A scenario's faults, put where they strike; the kinds stand in `fault_kinds`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from boards.assembly import AssembledBoard
from boards.hints import did_you_mean
from hal.emulated.virtual_time import FAR, SECOND
from host.record.errors import UserError
from host.record.result import FaultUse
from host.run.fault_kinds import KINDS
from host.run.fault_site import Site, name_of, target_in
from host.run.surroundings import ReceiverSight
from host.sim.gnss.faults import GNSS_FAULT_KINDS, glitches_of
from host.sim.gnss.schedule import Glitch, Window
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import Fault


@dataclass(frozen=True)
class Placed:
    """A fault in its place; `fired` tells how often it has struck, `lift` ends it (see `Effect`)."""

    fault: Fault
    fired: Callable[[], int]
    lift: Callable[[], None] | None = None

    def use(self) -> FaultUse:
        """The row of the result."""
        fault = self.fault
        return FaultUse(name_of(fault), fault.kind, fault.target, fault.at_s, fault.duration_s, self.fired())


def place_faults(
    faults: Sequence[Fault],
    board: AssembledBoard,
    sights: dict[str, ReceiverSight],
    seed: int,
    duration_ns: int,
) -> list[Placed]:
    """Install all faults of a run of `duration_ns`.

    Raises UserError for a kind, target or parameter that does not exist, and for a fault that could not
    strike because the run ends before.
    """
    for fault in faults:
        if fault.at_s * SECOND >= duration_ns:
            raise UserError(
                f"fault {name_of(fault)!r}: at_s = {fault.at_s:g} is not before the end of the run at"
                f" {duration_ns / SECOND:g} s; for example at_s = {duration_ns / SECOND / 2:g}"
            )
    return [_of_scenario(fault, board, sights, seed) for fault in faults]


def _of_scenario(fault: Fault, board: AssembledBoard, sights: dict[str, ReceiverSight], seed: int) -> Placed:
    if fault.kind in GNSS_FAULT_KINDS:  # the world has it already
        sight = target_in(fault, sights, "receiver")
        return Placed(fault, lambda: sight.fired(name_of(fault)))
    return place_on_board(fault, board, seed, round(fault.at_s * SECOND))


def place_now(fault: Fault, board: AssembledBoard, sights: dict[str, ReceiverSight], seed: int) -> Placed:
    """Install a fault that begins at this instant, whatever its `at_s`. Raises as `place_faults`."""
    now_ns = board.time.now
    if fault.kind not in GNSS_FAULT_KINDS:
        return place_on_board(fault, board, seed, now_ns)
    sight = target_in(fault, sights, "receiver")
    glitch = begun(fault, now_ns, seed)
    sight.strike(glitch)

    def lift() -> None:
        glitch.window = Window(now_ns, board.time.now)

    return Placed(fault, lambda: glitch.fired, lift)


def begun(fault: Fault, start_ns: int, seed: int) -> Glitch:
    """A fault of a receiver's own solution that begins at `start_ns`. Raises UserError."""
    try:
        (glitch,) = glitches_of([fault.model_copy(update={"at_s": 0.0})], fault.target, FAR, seed)
    except ScenarioError as error:
        raise UserError(str(error)) from None
    glitch.window = Window(start_ns, min(FAR, start_ns + glitch.window.end_ns))
    return glitch


def place_on_board(fault: Fault, board: AssembledBoard, seed: int, start_ns: int) -> Placed:
    """Install a fault of one of the `KINDS`, from `start_ns` on, whatever its `at_s`. Raises UserError."""
    maker = KINDS.get(fault.kind)
    if maker is None:
        hint = did_you_mean(fault.kind, [*KINDS, *GNSS_FAULT_KINDS])
        raise UserError(
            f"fault {name_of(fault)!r}: no kind of fault {fault.kind!r}; {hint} (docs/scenarios.md has"
            ' all of them; for example kind = "spi-missing")'
        )
    end_ns = FAR if fault.duration_s is None else start_ns + round(fault.duration_s * SECOND)
    try:
        return Placed(fault, *maker(Site(fault, board, start_ns, end_ns, seed)))
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        raise UserError(f"fault {name_of(fault)!r} ({fault.kind}): {error}") from None
