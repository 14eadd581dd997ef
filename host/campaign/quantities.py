"""What engineers ask about by name, as keys of `--set`: found in the board's description."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from boards.description import Board, load_board
from boards.hints import did_you_mean
from host.campaign.fault_plan import able
from host.record.errors import UserError


@dataclass(frozen=True, slots=True)
class Quantity:
    """A key that can be swept, and the values that are swept when none are given."""

    key: str
    unit: str
    values: tuple[str, ...]


def quantity(board_name: str, asked: str) -> Quantity | None:
    """The quantity called `asked`; None when it is a key itself. Raises UserError."""
    name, _, part = asked.partition(":")
    finder = FINDERS.get(name)
    if finder is None:
        if "." not in asked and "=" not in asked and ":" not in asked:
            known = did_you_mean(asked, FINDERS)
            raise UserError(
                f"--key {asked}: neither a quantity nor a key of --set; {known} (keys have dots:"
                " gnss.latency_s, board.buses.spi1.clock_hz)"
            )
        return None
    board = load_board(board_name)
    try:
        return finder(board, part)
    except LookupError as error:
        raise UserError(f"--key {asked}: {error.args[0]}") from None


def _bus_clock(board: Board, part: str) -> Quantity:
    """Of the inertial sensor's bus, else of the first chip's, unless one is named; a chip that is clocked in
    its own way has its own key."""
    on_buses = [(refdes, chip) for refdes, chip in board.chips.items() if chip.bus is not None]
    on_buses.sort(key=lambda one: not one[1].is_inertial)
    name = part or next((str(chip.bus) for _, chip in on_buses), "")
    if name not in board.buses:
        raise LookupError(f"{board.name} has no bus {name!r}; it has: {', '.join(board.buses) or 'none'}")
    key, clock_hz = f"board.buses.{name}.clock_hz", board.buses[name].clock_hz
    for refdes, chip in on_buses:
        if chip.bus == name and chip.spi is not None and chip.spi.clock_hz:
            key, clock_hz = f"board.chips.{refdes}.spi.clock_hz", chip.spi.clock_hz
            break
    values = tuple(str(clock_hz // divisor) for divisor in (64, 32, 16, 8, 4, 2, 1))
    return Quantity(key, "Hz", values)


def _interrupt_latency(board: Board, part: str) -> Quantity:
    name = _processor(board, part)
    microsecond = board.processors[name].clock_hz / 1e6
    values = ("12", *(str(round(us * microsecond)) for us in (10, 100, 500, 1000, 2000, 5000)))
    return Quantity(f"board.processors.{name}.interrupt_entry_cycles", "cycles", values)


def _sample_clock_error(board: Board, part: str) -> Quantity:
    """Of a chip that samples by a clock of its own: the inertial sensor, unless one is named."""
    clocked = set(able("set_clock_error")(board))
    chips = [
        refdes
        for refdes, chip in board.chips.items()
        if part in ("", refdes) and ("clock_error_ppm" in chip.parameters or refdes in clocked)
    ]
    chips.sort(key=lambda refdes: not board.chips[refdes].is_inertial)
    if not chips:
        raise LookupError(
            f"{board.name} has no chip {part} with a parameter clock_error_ppm".replace("  ", " ")
        )
    key = f"board.chips.{chips[0]}.parameters.clock_error_ppm"
    return Quantity(key, "ppm", ("-20000.0", "-10000.0", "0.0", "10000.0", "20000.0"))


def _gnss_latency(board: Board, _part: str) -> Quantity:
    if not any(chip.world == "gnss" for chip in board.chips.values()):
        raise LookupError(f"{board.name} has no GNSS receiver")
    return Quantity("gnss.latency_s", "s", ("0.02", "0.08", "0.15", "0.3", "0.5"))


def _task_budget(board: Board, part: str) -> Quantity:
    """Cycles of one piece of work, of the longest one unless one is named: 1 to 50 times as many."""
    for name, processor in board.processors.items():
        work = part or max(processor.costs, key=lambda one: processor.costs[one], default="")
        if work in processor.costs:
            values = tuple(str(factor * processor.costs[work]) for factor in (1, 2, 5, 10, 20, 50))
            return Quantity(f"board.processors.{name}.costs.{work}", "cycles", values)
    known = ", ".join(cost for processor in board.processors.values() for cost in processor.costs)
    raise LookupError(f"{board.name} has no budget {part!r}; it has: {known or 'none'}")


def _processor(board: Board, part: str) -> str:
    name = part or next(iter(board.processors))
    if name not in board.processors:
        raise LookupError(f"{board.name} has no processor {part!r}; it has: {', '.join(board.processors)}")
    return name


FINDERS: dict[str, Callable[[Board, str], Quantity]] = {
    "bus-clock": _bus_clock,
    "interrupt-latency": _interrupt_latency,
    "sample-clock-error": _sample_clock_error,
    "gnss-latency": _gnss_latency,
    "task-budget": _task_budget,
}
