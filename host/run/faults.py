"""A scenario's faults, put where they strike.

| kind | target | parameters |
| --- | --- | --- |
| spi-bit-errors | SPI device | probability a bit, line = "miso" or "mosi" |
| spi-missing | SPI device | level = true: reads 0xFF, false: 0x00 |
| spi-register | SPI device | register, value: reads of one register give value (a wrong chip id) |
| chip-reset, chip-off | reference designator | supply dip; supply off for the duration |
| uart-cut | UART | cable pulled: nothing reaches the processor |
| uart-bit-errors | UART | probability a bit |
| uart-truncation | UART | keep bytes of each message |
| uart-wrong-baud | UART | baud at which the other end sends |
| uart-garbage | UART | length in bytes of noise |
| can-disturbance | CAN bus | no frame gets through |
| log-removed | log | the card is pulled |
| nav-nan | processor | a kernel leaves NaN behind in its state |
| cpu-reset | processor | reset of the processor |
| gnss-time-jump, gnss-position-jump | reference designator of the receiver | struck by the simulator itself |
| gnss-spoofing, gnss-jamming | reference designator of the receiver | struck by the simulator itself |
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from boards.assembly import AssembledBoard
from boards.hints import did_you_mean
from hal.emulated import faults as wire_faults
from hal.emulated.virtual_time import FAR, SECOND
from host.record.errors import UserError
from host.record.result import FaultUse
from host.run.surroundings import ReceiverSight
from host.sim.gnss.faults import GNSS_FAULT_KINDS, glitches_of
from host.sim.gnss.schedule import Window
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import Fault


class Effect(NamedTuple):
    """What a fault does where it was put."""

    fired: Callable[[], int]
    """How often it has struck."""
    lift: Callable[[], None] | None = None
    """Ends it before its time. None: it is over in an instant, or ends by itself."""


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


def name_of(fault: Fault) -> str:
    """What a fault is called in results; no two faults of a scenario are called alike."""
    return fault.name or f"{fault.kind} {fault.target}"


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
        sight = _target(fault, sights, "receiver")
        return Placed(fault, lambda: sight.fired(name_of(fault)))
    return place_on_board(fault, board, seed, round(fault.at_s * SECOND))


def place_now(fault: Fault, board: AssembledBoard, sights: dict[str, ReceiverSight], seed: int) -> Placed:
    """Install a fault that begins at this instant, whatever its `at_s`. Raises as `place_faults`."""
    now_ns = board.time.now
    if fault.kind not in GNSS_FAULT_KINDS:
        return place_on_board(fault, board, seed, now_ns)
    sight = _target(fault, sights, "receiver")
    try:
        (glitch,) = glitches_of([fault.model_copy(update={"at_s": 0.0})], fault.target, FAR, seed)
    except ScenarioError as error:
        raise UserError(str(error)) from None
    glitch.window = Window(now_ns, min(FAR, now_ns + glitch.window.end_ns))
    sight.strike(glitch)

    def lift() -> None:
        glitch.window = Window(now_ns, board.time.now)

    return Placed(fault, lambda: glitch.fired, lift)


def place_on_board(fault: Fault, board: AssembledBoard, seed: int, start_ns: int) -> Placed:
    """Install a fault of one of the `KINDS`, from `start_ns` on, whatever its `at_s`. Raises UserError."""
    maker = KINDS.get(fault.kind)
    if maker is None:
        hint = did_you_mean(fault.kind, [*KINDS, *GNSS_FAULT_KINDS])
        raise UserError(f"fault {name_of(fault)!r}: no kind of fault {fault.kind!r}; {hint}")
    end_ns = FAR if fault.duration_s is None else start_ns + round(fault.duration_s * SECOND)
    try:
        return Placed(fault, *maker(Site(fault, board, start_ns, end_ns, seed)))
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        raise UserError(f"fault {name_of(fault)!r} ({fault.kind}): {error}") from None


@dataclass(frozen=True)
class Site:
    """Where and when one fault is to strike."""

    fault: Fault
    board: AssembledBoard
    start: int
    end: int
    seed: int

    def of(self, table: dict[str, Any], what: str) -> Any:
        """The target in one of the board's tables."""
        return _target(self.fault, table, what)

    @property
    def stream(self) -> dict[str, Any]:
        """Seed and name of the fault's own randomness; names of channels of chips hold no blanks."""
        name, label = name_of(self.fault), f"{self.fault.kind} {self.fault.target}"
        unnamed = name.startswith(label) and ":" not in name
        return {"seed": self.seed, "name": name if unnamed else f"{label}: {name}"}

    def parameters(self, **defaults: Any) -> dict[str, Any]:
        """The fault's parameters over their defaults. Raises ValueError for an unknown one."""
        for key, value in self.fault.parameters.items():
            if key not in defaults:
                known = ", ".join(f"{name} = {default!r}" for name, default in defaults.items()) or "none"
                raise ValueError(f"parameters.{key} = {value!r} is unknown; parameters are: {known}")
            if not _is_like(value, defaults[key]):
                raise ValueError(
                    f"parameters.{key} = {value!r} is of the wrong kind;"
                    f" for example {key} = {defaults[key]!r}"
                )
        return {**defaults, **self.fault.parameters}


def _is_like(value: Any, example: Any) -> bool:
    """Whether a parameter is of the kind of its default; a whole number may stand for any number."""
    if isinstance(example, float):
        return isinstance(value, int | float) and not isinstance(value, bool)
    return type(value) is type(example)


def _target(fault: Fault, table: Any, what: str) -> Any:
    if fault.target not in table:
        hint = did_you_mean(fault.target, table)
        raise UserError(f"fault {name_of(fault)!r}: the board has no {what} {fault.target!r}; {hint}")
    return table[fault.target] if isinstance(table, dict) else None


def _on_spi(kind: type[wire_faults.SpiFault], **defaults: Any) -> Callable[[Site], Effect]:
    def place(site: Site) -> Effect:
        options = site.parameters(**defaults)
        if kind is wire_faults.SpiBitErrors:
            options |= site.stream
        fault = kind(site.start, site.end, **options)
        fault.install(site.of(site.board.spi_devices, "SPI device"))
        return Effect(lambda: fault.fired, fault.lift)

    return place


def _on_uart(
    kind: Callable[..., wire_faults.UartFault], seeded: bool = False, **defaults: Any
) -> Callable[[Site], Effect]:
    def place(site: Site) -> Effect:
        options = site.parameters(**defaults)
        if seeded:
            options |= site.stream
        ends_by_itself = kind is wire_faults.UartGarbage
        times = (site.start,) if ends_by_itself else (site.start, site.end)
        fault = kind(*times, **options)
        fault.install(site.of(site.board.to_board, "UART"))
        return Effect(lambda: fault.fired, None if ends_by_itself else fault.lift)

    return place


def _disturb_can(site: Site) -> Effect:
    site.parameters()
    fault = wire_faults.CanDisturbance(site.start, site.end)
    fault.install(site.of(site.board.can_buses, "CAN bus"))
    return Effect(lambda: fault.fired, fault.lift)


def _once(site: Site, begin: Callable[[], Any], end: Callable[[], Any] | None = None) -> Effect:
    """A fault that happens at an instant, and perhaps ends at another."""
    site.parameters()
    fired = 0
    over = False

    def strike() -> None:
        nonlocal fired
        if not over:
            fired += 1
            begin()

    def pass_over() -> None:
        nonlocal over
        if fired and not over and end is not None:
            end()
        over = True

    site.board.time.at(site.start, strike)
    if end is None:
        return Effect(lambda: fired)
    if site.end < FAR:
        site.board.time.at(site.end, pass_over)
    return Effect(lambda: fired, pass_over)


def _reset_chip(site: Site) -> Effect:
    chip = site.of(site.board.chips, "chip")

    def dip() -> None:
        chip.power(False)
        chip.power(True)

    return _once(site, dip)


def _switch_chip_off(site: Site) -> Effect:
    chip = site.of(site.board.chips, "chip")
    return _once(site, lambda: chip.power(False), lambda: chip.power(True))


def _pull_card(site: Site) -> Effect:
    log = site.of(site.board.logs, "log")
    return _once(site, log.remove, log.insert)


def _spoil_state(site: Site) -> Effect:
    program = site.of(site.board.programs, "processor")
    return _once(site, program.spoil)


def _reset_cpu(site: Site) -> Effect:
    cpu = site.of(site.board.cpus, "processor")
    return _once(site, lambda: cpu.reset("fault of the scenario"))


KINDS: dict[str, Callable[[Site], Effect]] = {
    "spi-bit-errors": _on_spi(wire_faults.SpiBitErrors, probability=1e-4, line="miso"),
    "spi-missing": _on_spi(wire_faults.SpiMissingChip, level=True),
    "spi-register": _on_spi(wire_faults.SpiRegisterOverride, register=0x00, value=0x00),
    "chip-reset": _reset_chip,
    "chip-off": _switch_chip_off,
    "uart-cut": _on_uart(wire_faults.UartCut),
    "uart-bit-errors": _on_uart(wire_faults.UartBitErrors, seeded=True, probability=1e-3),
    "uart-truncation": _on_uart(wire_faults.UartTruncation, keep=20),
    "uart-wrong-baud": _on_uart(wire_faults.UartWrongBaud, baud=38_400),
    "uart-garbage": _on_uart(wire_faults.UartGarbage, seeded=True, length=500),
    "can-disturbance": _disturb_can,
    "log-removed": _pull_card,
    "nav-nan": _spoil_state,
    "cpu-reset": _reset_cpu,
}
