"""Strict replay: the firmware runs on the recorded traffic, and everything it does must repeat exactly.

The board is assembled as always; stand-ins take its chips' place. Faults that struck what is no chip and no
wire to one (processor, CAN bus, log card) are put in their places again; all others are in the traffic.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

from boards.assembly import assemble
from boards.description import Board
from firmware.numerics.dialect import entries_named
from firmware.numerics.subnormals import check_subnormals
from hal.emulated.i2c import I2cTransfer
from hal.emulated.pins import Net
from hal.emulated.virtual_time import FAR, SECOND
from host.capture.blocks import (
    CAN_SCHEMA,
    OLD_CAN_SCHEMA,
    OLD_SENT_SCHEMA,
    PIN,
    SENT_SCHEMA,
    i2c_topic,
    pin_topic,
    spi_topic,
    uart_topic,
    unpack,
)
from host.capture.reader import CaptureReader, Window
from host.capture.writer import CAPTURE_FORMAT, FORMAT_2, FORMAT_3
from host.record.errors import UserError
from host.replay.comparison import Comparison, Difference, shown_bytes, shown_transfer
from host.replay.control_tape import ControlTape, is_own
from host.replay.request import REPLAY_FORMAT, ReplayRequest
from host.replay.setting import board_text_differs, recorded_setup
from host.replay.stand_ins import (
    Diverged,
    Exchange,
    I2cTape,
    LineTape,
    NetTape,
    NoSurroundings,
    with_stand_ins,
)
from host.run.faults import place_faults
from host.run.garbage import collect_young, undisturbed
from host.run.intake import HOST_PORT
from host.run.listening import Ears
from host.run.setup import Setup
from host.run.warm_up import BOOT_NS, compile_missing

REPLAYED_FORMATS = (CAPTURE_FORMAT, FORMAT_3, FORMAT_2)
WARM_UP_WINDOWS = 2
CLEAN_UP_EVERY = 50
"""Windows between two looks of the collector of cycles."""


@dataclass(frozen=True, slots=True)
class StrictResult:
    """What a strict replay found."""

    capture: str
    board: str
    scenario: str
    profile: str
    seed: int
    duration_s: float
    wall_s: float
    capture_complete: bool
    """False: the recorded run did not reach its end; replayed is what was recorded."""
    recorded_state_hash: str | None
    state_hash: str | None
    """None: the replay stopped at a difference."""
    transactions: int
    """On chip selects and I²C buses, all of which repeated."""
    bytes_compared: int
    """Of records of what the board sent."""
    difference: Difference | None

    @property
    def ok(self) -> bool:
        """Whether everything repeated, the final state too."""
        if self.difference is not None:
            return False
        return self.recorded_state_hash in (None, self.state_hash)

    def to_dict(self) -> dict[str, Any]:
        """For `--json`; the keys are stable."""
        factor = self.duration_s / self.wall_s if self.wall_s > 0 else None
        return {
            "format": REPLAY_FORMAT,
            "mode": "strict",
            "ok": self.ok,
            **asdict(self),
            "real_time_factor": factor,
        }


def replay_strict(request: ReplayRequest) -> StrictResult:
    """Replay a capture. Raises UserError for whatever the user can mend."""
    check_subnormals()
    reader = CaptureReader(request.capture)
    windows = reader.windows()
    first = list(islice(windows, WARM_UP_WINDOWS))
    setup = _checked_setup(reader, request)
    if not first:
        raise UserError(f"capture {request.capture}: it was cut off before anything was recorded")
    _warm_up(setup, reader, first, request)
    player = Player(setup, reader, int(reader.manifest["seed"]))

    def all_windows() -> Iterator[Window]:
        yield from first
        yield from windows

    progress = request.progress
    total_s = None if progress is None else reader.recorded_s()

    def tell(now_s: float) -> None:
        if progress is not None and total_s:
            progress(now_s, total_s)

    wall_s = player.play(all_windows(), tell)
    recorded_hash = (reader.summary or {}).get("state_hash")
    return StrictResult(
        capture=str(request.capture),
        board=setup.board.name,
        scenario=setup.scenario.name,
        profile=setup.profile_name,
        seed=int(reader.manifest["seed"]),
        duration_s=player.now_ns / SECOND,
        wall_s=wall_s,
        capture_complete=reader.complete and recorded_hash is not None,
        recorded_state_hash=recorded_hash,
        state_hash=None if player.difference is not None else player.ears.hexdigest(),
        transactions=player.transactions,
        bytes_compared=sum(wire.compared_bytes for wire in player.comparison.wires.values()),
        difference=player.difference,
    )


class Player:
    """A board on recorded traffic. `difference`: where it first did something else; None: nowhere."""

    def __init__(self, setup: Setup, reader: CaptureReader, seed: int) -> None:
        description, tapes = with_stand_ins(setup.board)
        self._reader = reader
        self.board = board = assemble(description, setup.profile, NoSurroundings())
        own = [fault for fault in setup.scenario.fault if is_own(fault, description)]
        self._control = ControlTape(board, seed, place_faults(own, board, {}, seed, FAR))
        outputs = _output_nets(setup.board)
        can_schema = OLD_CAN_SCHEMA if reader.format == FORMAT_2 else CAN_SCHEMA
        sent_schema = SENT_SCHEMA if reader.format == CAPTURE_FORMAT else OLD_SENT_SCHEMA
        self.comparison = Comparison(outputs, can_schema, sent_schema)
        self.ears = Ears(board, HOST_PORT, _ignore, self.comparison)
        self.difference: Difference | None = None
        self.now_ns = 0
        self._lines = {uart_topic(port, "rx"): LineTape(wire) for port, wire in board.to_board.items()}
        self._nets = {
            pin_topic(name): NetTape(net) for name, net in board.nets.items() if name not in outputs
        }
        self._spi = {spi_topic(name): tape for name, tape in tapes.items()}
        self._i2c: dict[str, I2cTape] = {}
        for name, bus in board.i2c_buses.items():
            tape = self._i2c[i2c_topic(name)] = I2cTape(name)
            bus.player = tape.play
        self._check_topics(reader.raw_topics, setup.board)

    @property
    def transactions(self) -> int:
        """How many have repeated."""
        on_spi = sum(tape.count for tape in self._spi.values())
        return on_spi + sum(tape.count for tape in self._i2c.values())

    def play(self, windows: Iterator[Window], progress: Callable[[float], None]) -> float:
        """Work all windows off, or up to the first difference; returns the wall-clock seconds."""
        board = self.board
        with undisturbed():
            begin = time.perf_counter()
            for number, window in enumerate(windows):
                self.load(window)
                self._run_until(window.end_ns)
                if self.difference is not None:
                    break
                if number % CLEAN_UP_EVERY == 0:
                    collect_young()
                    progress(self.now_ns / SECOND)
            wall_s = time.perf_counter() - begin
        board.machine.power_off()
        return wall_s

    def load(self, window: Window) -> None:
        """Put recorded traffic where it will be asked for. Raises UserError when it is damaged."""
        try:
            self._load(window)
        except (struct.error, ArithmeticError):
            for topic, block in window.raw.items():
                for _record in unpack(str(self._reader.raw_schema(topic)), topic, block):
                    pass
            raise

    def _load(self, window: Window) -> None:
        self._control.load(window.control)
        starts: dict[int, str] = {}
        for topic, tape in self._spi.items():
            if topic in window.raw:
                starts |= dict.fromkeys(tape.load(window.raw[topic]), topic)
        effects: dict[str, dict[int, list[tuple[Net, bool]]]] = {topic: {} for topic in self._spi}
        for topic, net_tape in self._nets.items():
            if topic not in window.raw:
                continue
            changes = [change for (change,) in PIN.iter_unpack(window.raw[topic])]
            net_tape.load(change for change in changes if change >> 1 not in starts)
            for change in changes:
                start_ns = change >> 1
                if start_ns in starts:
                    chip = effects[starts[start_ns]]
                    chip.setdefault(start_ns, []).append((net_tape.net, bool(change & 1)))
        for topic, found in effects.items():
            self._spi[topic].load_effects(found)
        for topic, block in window.raw.items():
            if topic in self._lines:
                self._lines[topic].load(block)
            elif topic in self._i2c:
                self._i2c[topic].load(topic, block)
            else:
                self.comparison.load(topic, block)

    def _run_until(self, end_ns: int) -> None:
        try:
            self.board.machine.run_until(end_ns)
            self.now_ns = end_ns
            self.ears.hand_on()
            self.comparison.flush(end_ns)
            self.difference = self.comparison.difference or self._left_out(end_ns)
        except Diverged as diverged:
            self.now_ns = self.board.time.now
            self.ears.hand_on()
            found = _bus_difference(diverged)
            self.comparison.flush(found.time_ns - 1)
            self.difference = self.comparison.difference or found

    def _left_out(self, now_ns: int) -> Difference | None:
        """A recorded transaction that has not come."""
        for topic, tape in self._spi.items():
            exchange = tape.waiting
            if exchange is not None and exchange[0] <= now_ns:
                return Difference(exchange[0], topic, _shown(exchange), "nothing")
        for topic, i2c_tape in self._i2c.items():
            transfer = i2c_tape.waiting
            if transfer is not None and transfer.end_ns <= now_ns:
                return Difference(transfer.start_ns, topic, _shown(transfer), "nothing")
        return None

    def _check_topics(self, topics: list[str], description: Board) -> None:
        """What the board has and what was recorded must be the same wires."""
        has = {*self._spi, *self._i2c, *self._lines, *self._nets, *self.comparison.wires}
        kinds = ("/spi/", "/i2c/", "/uart/", "/can/", "/pin/")
        recorded = {topic for topic in topics if topic.startswith(kinds)}
        for where, more in (("the board has", has - recorded), ("the capture has", recorded - has)):
            if more:
                raise UserError(
                    f"the capture is not of this board {description.name!r}: only {where} {min(more)}"
                    " (name the board it was made with, --board; or replay with --mode physical)"
                )


def _checked_setup(reader: CaptureReader, request: ReplayRequest) -> Setup:
    if reader.format not in REPLAYED_FORMATS:
        raise UserError(
            f"capture {request.capture}: its format is {reader.format}; a strict replay needs"
            f" {', '.join(REPLAYED_FORMATS[:-1])} or {REPLAYED_FORMATS[-1]} (pins and exact times of lines);"
            " record it anew with navtwin run"
        )
    begin_s = reader.cut_from_s
    if begin_s > 0.0:
        raise UserError(
            f"capture {request.capture}: it was cut and begins at {begin_s:g} s; a strict replay begins where"
            " the board was switched on: cut with --from 0, or use --mode physical"
        )
    setup = recorded_setup(reader.manifest, request.board, request.profile)
    recorded = str(reader.manifest["board"])
    if setup.board.name != recorded:
        raise UserError(
            f"capture {request.capture}: it is of the board {recorded!r}, not {setup.board.name!r};"
            " another board can only be fed the recorded quantities: --mode physical"
        )
    if request.notice is not None and board_text_differs(reader.manifest, request.board):
        request.notice("note: board.toml is not the one the capture was made with")
    return setup


def _warm_up(setup: Setup, reader: CaptureReader, first: list[Window], request: ReplayRequest) -> None:
    """Compile or load what the firmware calls, on a board that is thrown away."""
    seed = int(reader.manifest["seed"])
    with entries_named() as kernels:
        booted = Player(setup, reader, seed)
        booted.load(first[0])
        booted.board.machine.run_until(BOOT_NS)
    compile_missing(kernels, _nothing, request.notice)
    Player(setup, reader, seed).play(iter(first), _ignore)


def _output_nets(description: Board) -> set[str]:
    return {pin.net for pin in description.pins.values() if pin.use == "output" and pin.wired}


def _bus_difference(diverged: Diverged) -> Difference:
    recorded = diverged.recorded
    time_ns = min(one[0] for one in (recorded, diverged.replayed) if one is not None)
    shown = "nothing more" if recorded is None else _shown(recorded)
    is_i2c = isinstance(diverged.replayed, I2cTransfer)
    topic = i2c_topic(diverged.wire) if is_i2c else spi_topic(diverged.wire)
    return Difference(time_ns, topic, shown, _shown(diverged.replayed))


def _shown(exchange: Exchange | I2cTransfer) -> str:
    if isinstance(exchange, I2cTransfer):
        return shown_transfer(exchange)
    start_ns, end_ns, mosi, miso = exchange
    answer = f", MISO {shown_bytes(miso)}" if miso else ""
    return f"{start_ns / SECOND:.9f} s, {end_ns - start_ns} ns, MOSI {shown_bytes(mosi)}{answer}"


def _ignore(_what: object) -> None:
    pass


def _nothing() -> None:
    pass
