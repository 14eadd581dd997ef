"""Every kind of fault at every place of a board where it can strike."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

from boards.description import Board
from boards.hints import did_you_mean
from host.campaign.plan import Plan
from host.record.command_line import toml
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.fault_kinds import KINDS
from host.sim.gnss.faults import (
    BASELINE_JUMP,
    BASELINE_LOST,
    GNSS_FAULT_KINDS,
    JAMMING,
    POSITION_JUMP,
    SPOOFING,
    TIME_JUMP,
)

NO_FAULT = "[]"


@dataclass(frozen=True, slots=True)
class Strike:
    """One fault of the sheet."""

    kind: str
    target: str
    at_s: float
    duration_s: float | None
    parameters: tuple[tuple[str, float], ...] = ()

    def as_value(self) -> str:
        """The scenario's list of faults with this one alone, as `--set fault=…` takes it."""
        fault: dict[str, object] = {"kind": self.kind, "target": self.target, "at_s": self.at_s}
        if self.duration_s is not None:
            fault["duration_s"] = self.duration_s
        if self.parameters:
            fault["parameters"] = dict(self.parameters)
        return toml([fault])


def strikes(board: Board, at_s: float, duration_s: float, only: Sequence[str] = ()) -> Iterator[Strike]:
    """All faults of a board, in the order of kinds, then of the board's parts; or `only` some kinds."""
    kinds = (*KINDS, *GNSS_FAULT_KINDS)
    for kind in only:
        if kind not in kinds:
            raise UserError(f"--only {kind}: no such kind of fault; {did_you_mean(kind, kinds)}")
    for kind in (kind for kind in kinds if not only or kind in only):
        at_once = kind in AT_ONCE
        for target in TARGETS[kind](board):
            rare = kind == "i2c-bit-errors" and target in _command_channels(board)
            parameters = ONCE_A_SECOND if rare else PARAMETERS.get(kind, ())
            yield Strike(kind, target, at_s, None if at_once else duration_s, parameters)


def possible(plan: Plan, wanted: Iterable[Strike]) -> tuple[list[Strike], list[tuple[Strike, str]]]:
    """Those that the board can take, and those that it cannot, with the reason."""
    from host.run.runner import check

    can: list[Strike] = []
    cannot: list[tuple[Strike, str]] = []
    usual = plan.request(next(plan.setups()), plan.seeds[0])
    check(usual)
    for strike in wanted:
        try:
            check(_with(usual, strike))
            can.append(strike)
        except UserError as error:
            cannot.append((strike, str(error)))
    return can, cannot


def _with(request: RunRequest, strike: Strike) -> RunRequest:
    return replace(request, overrides=(*request.overrides, f"fault={strike.as_value()}"))


def _spi_devices(board: Board) -> list[str]:
    """Of sensors: display and keys have no part in navigation."""
    return [
        chip.name or refdes
        for refdes, chip in board.chips.items()
        if chip.is_sensor and chip.bus is not None and board.buses[chip.bus].kind == "spi"
    ]


def _spi_devices_with_a_twin(board: Board) -> list[str]:
    """Those beside another of the same part."""
    parts = {chip.name or refdes: chip.part for refdes, chip in board.chips.items()}
    devices = _spi_devices(board)
    return [name for name in devices if sum(parts[other] == parts[name] for other in devices) > 1]


def _packet_links(board: Board) -> list[str]:
    return [name for name, joint in board.interconnects.items() if joint.kind == "spi-packets"]


def _chips(board: Board) -> list[str]:
    return [refdes for refdes, chip in board.chips.items() if chip.is_sensor]


def able(ability: str) -> Callable[[Board], list[str]]:
    """Chips whose model has a method or property of that name."""

    def chips(board: Board) -> list[str]:
        return [refdes for refdes, chip in board.chips.items() if hasattr(_model(chip.model), ability)]

    return chips


def _model(name: str) -> Any:
    module, _, attribute = name.partition(":")
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, AttributeError):
        return None  # assembling the board tells of it


def _clocked(board: Board) -> list[str]:
    """Chips with a clock that matters: of samples, or of a serial line."""
    sampling = able("set_clock_error")(board)
    return [refdes for refdes, chip in board.chips.items() if chip.uart is not None or refdes in sampling]


def _command_channels(board: Board) -> list[str]:
    return [name for name, joint in board.interconnects.items() if joint.kind == "i2c-commands"]


def _i2c_devices(board: Board) -> list[str]:
    """Slaves: chips, and processors that take commands."""
    chips = [
        chip.name or refdes
        for refdes, chip in board.chips.items()
        if chip.bus is not None and board.buses[chip.bus].kind == "i2c"
    ]
    return chips + _command_channels(board)


def _i2c_buses(board: Board) -> list[str]:
    return [name for name, bus in board.buses.items() if bus.kind == "i2c"] + _command_channels(board)


def _nets_from_chips(board: Board) -> list[str]:
    """Nets on which a chip tells a processor something."""
    heard = {pin.net for pin in board.pins.values() if pin.wired and pin.use != "output"}
    sensors = [chip for chip in board.chips.values() if chip.is_sensor]
    return [net for chip in sensors for net in chip.pins.values() if net in heard]


def _nets_that_tell(board: Board) -> list[str]:
    """Those, and the nets on which one processor tells another something."""
    pins = [pin for pin in board.pins.values() if pin.wired]
    driven = {(pin.net, pin.processor) for pin in pins if pin.use == "output"}
    heard = {(pin.net, pin.processor) for pin in pins if pin.use != "output"}
    between = {net for net, driver in driven for other, hearer in heard if net == other and driver != hearer}
    return list(dict.fromkeys([*_nets_from_chips(board), *sorted(between)]))


def _lines_from_chips(board: Board) -> list[str]:
    """UARTs at which a chip talks to the processor; nothing comes in at the others."""
    return [chip.uart for chip in board.chips.values() if chip.uart is not None]


def _receivers(board: Board) -> list[str]:
    return [refdes for refdes, chip in board.chips.items() if chip.world == "gnss"]


def _receivers_with_two_antennas(board: Board) -> list[str]:
    return [refdes for refdes in _receivers(board) if board.chips[refdes].second_antenna_m is not None]


def _processors(board: Board) -> list[str]:
    return list(board.processors)


TARGETS: dict[str, Callable[[Board], list[str]]] = {
    "spi-bit-errors": _spi_devices,
    "spi-missing": _spi_devices,
    "spi-register": _spi_devices,
    "spi-stuck": _spi_devices,
    "spi-word-slip": _spi_devices,
    "spi-late": _spi_devices,
    "spi-frozen": _spi_devices,
    "spi-swapped": _spi_devices_with_a_twin,
    "spi-byte-loss": _spi_devices,
    "spi-byte-duplication": _spi_devices,
    "i2c-nack": _i2c_devices,
    "i2c-bit-errors": _i2c_devices,
    "i2c-clock-stretch": _i2c_devices,
    "i2c-stuck": _i2c_buses,
    "packet-loss": _packet_links,
    "packet-bit-errors": _packet_links,
    "packet-word-slip": _packet_links,
    "pin-stuck": _nets_that_tell,
    "sensor-frozen": _chips,
    "sensor-stuck": able("measures"),
    "sensor-saturated": able("measures"),
    "sensor-drift": able("measures"),
    "sensor-turned": able("measures"),
    "chip-reset": _chips,
    "chip-off": _chips,
    "chip-wrong-id": able("pretend_id"),
    "chip-clock": _clocked,
    "chip-halt": able("halt"),
    "chip-flags": able("raise_flags"),
    "chip-supply": able("supply_v"),
    "uart-cut": _lines_from_chips,
    "uart-bit-errors": _lines_from_chips,
    "uart-byte-loss": _lines_from_chips,
    "uart-byte-duplication": _lines_from_chips,
    "uart-framing-errors": _lines_from_chips,
    "uart-parity": _lines_from_chips,
    "uart-overrun": _lines_from_chips,
    "uart-truncation": _lines_from_chips,
    "uart-wrong-baud": _lines_from_chips,
    "uart-garbage": _lines_from_chips,
    "can-disturbance": lambda board: list(board.can),
    "chip-busy": able("be_busy"),
    "log-removed": lambda board: list(board.logs),
    "nav-nan": _processors,
    "cpu-reset": _processors,
    TIME_JUMP: _receivers,
    POSITION_JUMP: _receivers,
    SPOOFING: _receivers,
    JAMMING: _receivers,
    BASELINE_LOST: _receivers_with_two_antennas,
    BASELINE_JUMP: _receivers_with_two_antennas,
}
AT_ONCE = ("chip-reset", "uart-garbage", "nav-nan", "cpu-reset")
"""Faults that have no duration."""
PARAMETERS: dict[str, tuple[tuple[str, float], ...]] = {
    TIME_JUMP: (("offset_s", 3600.0),),
    POSITION_JUMP: (("north_m", 100.0),),
    SPOOFING: (("north_mps", 2.0),),
    JAMMING: (("loss_db", 12.0),),
    BASELINE_JUMP: (("heading_deg", 5.0),),
    "uart-garbage": (("length", 20_000),),
}
ONCE_A_SECOND = (("probability", 0.02),)
"""For a channel on which a dozen bytes go once a second."""
