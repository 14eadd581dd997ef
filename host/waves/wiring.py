"""The buses of a capture and how they are clocked: names, clocks and modes from the board's text in its
manifest, devices and senders from what was recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from boards.description import Board
from hal.emulated.spi import SpiTiming
from host.capture.blocks import CanMessage, Traffic
from host.record.errors import UserError
from host.replay.setting import recorded_board
from host.waves.can_lines import CanLines
from host.waves.i2c_lines import I2cLines
from host.waves.lines import Tracer
from host.waves.spi_lines import SpiLines
from host.waves.uart_lines import UartLines

DESCRIBED = ("board", "board_text", "scenario", "scenario_text", "overrides")
EXAMPLES = {"spi": 5_250_000, "i2c": 400_000, "uart": 115_200, "can": 500_000}
RATES_UP_TO = 200_000_000
DIGITS = 20

BusKey = tuple[str, str]
"""(name, kind)."""


@dataclass(slots=True)
class RecordedBus:
    """One bus that a capture holds."""

    name: str
    kind: str
    topics: list[str] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)
    """Devices of an SPI bus, nodes that sent something on a CAN bus."""

    @property
    def label(self) -> str:
        """With its kind."""
        return f"{self.name} ({self.kind})"

    def add_topic(self, topic: str) -> None:
        """A further topic of it."""
        if topic not in self.topics:
            self.topics.append(topic)
            if self.kind == "spi":
                self.parts.append(topic.split("/")[2].split(".", 1)[-1])

    def note(self, record: Traffic) -> None:
        """Look who sent a frame."""
        if isinstance(record, CanMessage) and record.sender and record.sender not in self.parts:
            self.parts.append(record.sender)


def bus_of(topic: str) -> BusKey | None:
    """The bus of a raw topic; None: it is not of a bus."""
    parts = topic.split("/")
    if len(parts) < 3 or parts[1] not in EXAMPLES:
        return None
    return parts[2].split(".", 1)[0] if parts[1] == "spi" else parts[2], parts[1]


def chosen(buses: list[RecordedBus], wanted: list[str]) -> list[RecordedBus]:
    """The buses named, or all. UserError that lists the known ones."""
    if not buses:
        raise UserError("the capture holds no traffic of any bus")
    known = [bus.name for bus in buses]
    for name in wanted:
        if name not in known:
            told = ", ".join(bus.label for bus in buses)
            raise UserError(f"--bus {name}: the capture has no such bus; it has {told}")
    return [bus for bus in buses if not wanted or bus.name in wanted]


def given_rates(texts: list[str], buses: list[RecordedBus]) -> dict[str, int]:
    """NAME=HZ, parsed. UserError."""
    rates = {}
    known = [bus.name for bus in buses]
    for text in texts:
        name, equals, number = text.partition("=")
        example = f"for example --rate {known[0]}={EXAMPLES[buses[0].kind]}"
        if not equals or name not in known:
            raise UserError(f"--rate {text}: must be NAME=HZ with one of {', '.join(known)}; {example}")
        digits = number.replace("_", "")
        if not digits.isdecimal() or len(digits) > DIGITS or not 0 < int(digits) <= RATES_UP_TO:
            raise UserError(f"--rate {text}: {number!r} is no rate from 1 to {RATES_UP_TO} Hz; {example}")
        rates[name] = int(digits)
    return rates


def board_of(manifest: Mapping[str, Any]) -> Board | None:
    """The board as it was; None for a capture of something else, an import for example."""
    if any(name not in manifest for name in DESCRIBED):
        return None
    return recorded_board(manifest)


def tracers(buses: list[RecordedBus], board: Board | None, rates: Mapping[str, int]) -> list[Tracer]:
    """What draws each bus."""
    return [_tracer(bus, board, rates.get(bus.name)) for bus in buses]


def _tracer(bus: RecordedBus, board: Board | None, given: int | None) -> Tracer:
    rate = given or _stated_rate(bus, board)
    if rate is None:
        example = f"--rate {bus.name}={EXAMPLES[bus.kind]}"
        raise UserError(
            f"{bus.label}: the capture does not say at which rate it was clocked; say it, e.g. {example}"
        )
    match bus.kind:
        case "spi":
            mode = board.buses[bus.name].mode if board is not None and bus.name in board.buses else 0
            timings = {part: _spi_timing(bus.name, part, board, rate, given) for part in bus.parts}
            return SpiLines(bus.name, timings, mode)
        case "i2c":
            return I2cLines(bus.name, rate)
        case "uart":
            return UartLines(bus.name, rate, fixed=given is not None)
        case _:
            return CanLines(bus.name, rate, bus.parts)


def _stated_rate(bus: RecordedBus, board: Board | None) -> int | None:
    if board is not None and bus.kind in ("spi", "i2c") and bus.name in board.buses:
        return board.buses[bus.name].clock_hz
    if board is not None and bus.kind == "uart" and bus.name in board.uarts:
        return board.uarts[bus.name].baud
    if board is not None and bus.kind == "can" and bus.name in board.can:
        return board.can[bus.name].bitrate
    return None


def _spi_timing(name: str, device: str, board: Board | None, rate: int, given: int | None) -> SpiTiming:
    """How the chip at one chip select is clocked."""
    chips = {} if board is None else board.chips
    for refdes, chip in chips.items():
        if chip.bus == name and device == (chip.name or refdes) and chip.spi is not None:
            words = chip.spi
            clock_hz = given or words.clock_hz or rate
            return SpiTiming(clock_hz, words.bits_per_word, words.stall_ns, words.stall_clocks)
    return SpiTiming(rate)
