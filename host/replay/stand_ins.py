"""What takes the chips' place in a strict replay: recorded answers, levels and lines, at the recorded times.

A stand-in answers transaction k of its chip select with the recorded bytes, provided that the firmware does
exactly what it did: the same bytes out at the same instants. A level that a chip changed because of a
transaction (data ready that ends as the data are read) has the transaction's own time and changes within it;
every other change is an event. An I²C bus is played as a whole, whoever its slaves were. A net that nobody
heard when it changed is told to whoever begins to listen at that very instant, as lazy chips do.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Iterator
from itertools import count
from typing import Any

from boards.description import Board
from hal.emulated.i2c import I2cTransfer
from hal.emulated.pins import Net
from hal.emulated.uart_bytes import FORMS, SentBytes
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import VirtualTime
from host.capture.blocks import FORM_SHIFT, LINE_BAUD, LINE_HEAD, SPI_HEAD, I2cTransaction, unpack

Exchange = tuple[int, int, bytes, bytes]
"""start, end in ns, MOSI, MISO."""

MODEL = f"{__name__}:StandIn"
FIRST_ADDRESS = 0x08
"""Stand-ins on an I²C bus need some address each; nobody will ask there."""


class Diverged(BaseException):
    """The firmware did something else than recorded. Unwinds it, as a power cut does."""

    def __init__(
        self, wire: str, recorded: Exchange | I2cTransfer | None, replayed: Exchange | I2cTransfer
    ) -> None:
        super().__init__(wire)
        self.wire = wire
        self.recorded = recorded
        """None: nothing more was recorded."""
        self.replayed = replayed


def with_stand_ins(description: Board) -> tuple[Board, dict[str, SpiTape]]:
    """The board with every chip exchanged for a stand-in, and the tapes of those on chip selects."""
    addresses = count(FIRST_ADDRESS)
    chips = {}
    tapes: dict[str, SpiTape] = {}
    for refdes, chip in description.chips.items():
        tape = SpiTape(f"{chip.bus}.{chip.name or refdes}")
        if chip.bus is not None and description.buses[chip.bus].kind == "spi":
            tapes[tape.name] = tape
        parameters = {"pin_names": tuple(chip.pins), "address": next(addresses), "tape": tape}
        chips[refdes] = chip.model_copy(update={"model": MODEL, "parameters": parameters})
    return description.model_copy(update={"chips": chips}), tapes


class StandIn:
    """One chip's place on the board. Has the doors that `boards.assembly` uses of a chip."""

    def __init__(
        self,
        _time: VirtualTime,
        _world: object = None,
        _line: UartWire | None = None,
        *,
        pin_names: tuple[str, ...],
        address: int,
        tape: SpiTape,
    ) -> None:
        self.pins: dict[str, Net | None] = dict.fromkeys(pin_names)
        self.i2c = self
        self.address = address
        self.transaction = tape.transaction

    def receive(self, data: bytes, time_ns: int) -> None:
        """What the board sends is compared on the wire."""

    def power(self, on: bool) -> None:
        """Whether the chip had power is in what it answered."""


class SpiTape:
    """The recorded transactions of one chip select."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.count = 0
        """Transactions that have repeated."""
        self._exchanges: deque[Exchange] = deque()
        self._effects: dict[int, list[tuple[Net, bool]]] = {}

    def load(self, block: bytes) -> set[int]:
        """Append recorded transactions; returns when they start."""
        place = 0
        starts = []
        head, size, append = SPI_HEAD.unpack_from, SPI_HEAD.size, self._exchanges.append
        while place < len(block):
            start_ns, duration_ns, n = head(block, place)
            mosi = place + size
            miso = mosi + n
            place = miso + n
            starts.append(start_ns)
            append((start_ns, start_ns + duration_ns, block[mosi:miso], block[miso:place]))
        _check_end(place, block)
        return set(starts)

    def load_effects(self, effects: dict[int, list[tuple[Net, bool]]]) -> None:
        """Levels that change within the transactions that start at these times."""
        self._effects = effects

    @property
    def waiting(self) -> Exchange | None:
        """The recorded transaction that is to come next."""
        return self._exchanges[0] if self._exchanges else None

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period; see `hal.emulated.spi.SpiSlave`. Raises Diverged."""
        try:
            recorded = self._exchanges.popleft()
        except IndexError:
            raise Diverged(self.name, None, (start_ns, end_ns, bytes(mosi), b"")) from None
        if recorded[0] != start_ns or recorded[1] != end_ns or recorded[2] != mosi:
            raise Diverged(self.name, recorded, (start_ns, end_ns, bytes(mosi), b""))
        self.count += 1
        if start_ns in self._effects:
            for net, level in self._effects.pop(start_ns):
                net.set(level)
        return recorded[3]


class I2cTape:
    """The recorded transactions of one I²C bus: an `hal.emulated.i2c.I2cPlayer`."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.count = 0
        """Transactions that have repeated."""
        self._transfers: deque[I2cTransfer] = deque()

    def load(self, topic: str, block: bytes) -> None:
        """Append recorded transactions."""
        for record in unpack("navtwin.I2cBlock", topic, block):
            assert isinstance(record, I2cTransaction)
            self._transfers.append(record.transfer)

    @property
    def waiting(self) -> I2cTransfer | None:
        """The recorded transaction that is to come next."""
        return self._transfers[0] if self._transfers else None

    def play(self, start_ns: int, address: int, write: bytes, asked: int) -> I2cTransfer:
        """What came of the transaction that begins now. Raises Diverged."""
        recorded = self._transfers.popleft() if self._transfers else None
        if recorded is None or (recorded.start_ns, recorded.address, recorded.written, recorded.asked) != (
            start_ns,
            address,
            write,
            asked,
        ):
            raise Diverged(
                self.name, recorded, I2cTransfer(start_ns, start_ns, address, write, 0, asked, b"", None)
            )
        self.count += 1
        return recorded


class NetTape:
    """The recorded changes of one net that a chip drives."""

    def __init__(self, net: Net) -> None:
        self.net = net
        self._changes: deque[int] = deque()
        self._playing = False
        self._unheard_ns = -1
        net.on_first_listener = self._first_listener

    def load(self, changes: Iterator[int]) -> None:
        """Append changes (2·time + level) that are events."""
        self._changes.extend(changes)
        if self._changes and not self._playing:
            self._playing = True
            time = self.net.time
            time.at(max(self._changes[0] >> 1, time.now), self._play)

    def _play(self) -> int | None:
        net, changes = self.net, self._changes
        if not net.listened:
            self._unheard_ns = net.time.now
        net.set(bool(changes.popleft() & 1))
        if changes:
            return max(changes[0] >> 1, net.time.now)
        self._playing = False
        return None

    def _first_listener(self) -> None:
        net = self.net
        if self._unheard_ns == net.time.now:
            net.level = not net.level
            net.set(not net.level)


class LineTape:
    """What was recorded on the line into one UART."""

    def __init__(self, wire: UartWire) -> None:
        self._wire = wire

    def load(self, block: bytes) -> None:
        """Put recorded pieces on the line, each when it was told."""
        place = 0
        while place < len(block):
            told_ns, start_ns, first, baud, n = LINE_HEAD.unpack_from(block, place)
            data = block[place + LINE_HEAD.size : place + LINE_HEAD.size + n]
            place += LINE_HEAD.size + n
            kind = FORMS[baud >> FORM_SHIFT]
            piece = kind(data, start_ns, first, baud & LINE_BAUD) if baud else start_ns
            self._wire.time.at(max(told_ns, self._wire.time.now), lambda piece=piece: self._tell(piece))  # type: ignore[misc]
        _check_end(place, block)

    def _tell(self, piece: SentBytes | int) -> None:
        if isinstance(piece, SentBytes):
            self._wire.relay(piece)
        else:
            self._wire.retract(piece)


class NoSurroundings:
    """Implements `boards.assembly.Surroundings` for a board of stand-ins, which feel nothing."""

    def imu(self, _refdes: str, _chip: Any) -> Any:
        """Nothing."""

    def gnss(self, _refdes: str, _chip: Any) -> Any:
        """Nothing."""

    def compass(self, _refdes: str, _chip: Any) -> Any:
        """Nothing."""

    def ten_dof(self, _refdes: str, _chip: Any) -> Any:
        """Nothing."""

    def log_sink(self, _name: str) -> Any:
        """Nowhere: the log is made of what is compared already."""
        return _drop


def _check_end(place: int, block: bytes) -> None:
    """That the records of a block ended where it does."""
    if place > len(block):
        raise struct.error("a block ends inside a record")


def _drop(_block: bytes) -> None:
    pass
