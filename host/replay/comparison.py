"""What the replayed board sends, held against what was recorded: wire by wire, byte by byte."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest

from hal.emulated.can_bursts import HeardFrame
from hal.emulated.i2c import I2cTransfer
from host.capture.blocks import (
    CAN_SCHEMA,
    OLD_SENT_SCHEMA,
    SENT_HEAD,
    SENT_SCHEMA,
    UART_HEAD,
    CanMessage,
    I2cTransaction,
    LineCut,
    LinePiece,
    Mark,
    PinEdge,
    SpiTransaction,
    Traffic,
    UartChunk,
    can_topic,
    pin_topic,
    time_of,
    uart_topic,
    unpack,
)
from host.capture.can_senders import with_senders
from host.capture.writer import CanRecorder, UartRecorder

SHOWN_BYTES = 32
SHOWN_BEFORE = 8


@dataclass(frozen=True, slots=True)
class Difference:
    """The first place where a replay does something else than the recorded run."""

    time_ns: int
    wire: str
    recorded: str
    replayed: str

    def text(self) -> str:
        """Both sides, for people."""
        return (
            f"first difference at {self.time_ns / 1e9:.9f} s on {self.wire}\n"
            f"  recorded: {self.recorded}\n  replayed: {self.replayed}"
        )


@dataclass(slots=True)
class Compared:
    """One wire: records on both sides that have not been compared yet."""

    schema: str
    recorded: bytearray = field(default_factory=bytearray)
    replayed: bytearray = field(default_factory=bytearray)
    tape: list[int] = field(default_factory=list)
    """Of a pin: changes to be appended to `replayed`."""
    compared_bytes: int = 0

    def settle(self, topic: str, now_ns: int) -> Difference | None:
        """Forget what is equal; the first difference up to now in what is left."""
        self.drop_equal()
        return _difference(topic, self, now_ns) if self.recorded or self.replayed else None

    def drop_equal(self) -> None:
        """Forget the records that both sides have, when they are equal."""
        same = min(len(self.recorded), len(self.replayed))
        if self.recorded[:same] == self.replayed[:same]:
            self.compared_bytes += same
            del self.recorded[:same], self.replayed[:same]


class Comparison:
    """Implements `host.run.listening.WireRecords`: takes what the replayed board sends and compares it."""

    def __init__(
        self, output_nets: Iterable[str], can_schema: str = CAN_SCHEMA, sent_schema: str = SENT_SCHEMA
    ) -> None:
        """`can_schema`, `sent_schema`: of the capture's CAN topics, and of those of what UARTs send."""
        self._output_nets = set(output_nets)
        self._can_schema = can_schema
        self._sent_schema = sent_schema
        self.wires: dict[str, Compared] = {}
        self.difference: Difference | None = None

    def spi_recorder(self, bus: str) -> None:
        """Stand-ins compare transactions themselves."""

    def i2c_recorder(self, bus: str) -> None:
        """Tapes compare transactions themselves."""

    def line_recorder(self, port: str) -> None:
        """What comes to the board comes from the capture."""

    def uart_recorder(self, port: str, direction: str) -> UartRecorder:
        """For what a UART sends."""
        block = self._wire(uart_topic(port, direction), self._sent_schema).replayed
        tells_rates = self._sent_schema != OLD_SENT_SCHEMA

        def record(end_ns: int, data: bytes, baud: int = 0) -> None:
            nonlocal block
            n = len(data)
            block += SENT_HEAD.pack(end_ns, baud, n) if tells_rates else UART_HEAD.pack(end_ns, n)
            block += data

        return record

    def can_recorder(self, bus: str) -> CanRecorder:
        """For a CAN bus."""
        block = self._wire(can_topic(bus), self._can_schema).replayed
        names_senders = self._can_schema == CAN_SCHEMA

        def record(records: bytes, heard: Sequence[HeardFrame]) -> None:
            nonlocal block
            block += with_senders(records, heard) if names_senders else records

        return record

    def pin_tape(self, net: str) -> list[int] | None:
        """For a net that a processor drives; the others come from the capture."""
        return self._wire(pin_topic(net), "navtwin.PinBlock").tape if net in self._output_nets else None

    def show_sensor(self, refdes: str, part: str, bus: str) -> None:
        """Nothing is shown."""

    def glimpse(self) -> None:
        """Nothing is shown."""

    def clock(self, reset_ns: int, processor: str, rate_ppb: int) -> None:
        """Nothing is told."""

    def load(self, topic: str, block: bytes) -> None:
        """Recorded traffic up to the next mark."""
        if topic in self.wires:
            self.wires[topic].recorded += block

    def flush(self, now_ns: int | None = None) -> None:
        """Compare what both sides have; what is equal is forgotten."""
        for wire in self.wires.values():
            if wire.tape:
                wire.replayed += array("q", wire.tape).tobytes()
                wire.tape.clear()
            wire.drop_equal()
        left = any(wire.recorded or wire.replayed for wire in self.wires.values())
        if self.difference is None and now_ns is not None and left:
            self.difference = self._first(now_ns)

    def _first(self, now_ns: int) -> Difference | None:
        """The earliest difference up to now; what was recorded later is still to come."""
        found = [_difference(topic, wire, now_ns) for topic, wire in self.wires.items()]
        return min((one for one in found if one is not None), key=lambda one: one.time_ns, default=None)

    def _wire(self, topic: str, schema: str) -> Compared:
        self.wires[topic] = Compared(schema)
        return self.wires[topic]


def _difference(topic: str, wire: Compared, now_ns: int) -> Difference | None:
    pairs = zip_longest(_records(wire, topic, wire.recorded), _records(wire, topic, wire.replayed))
    for recorded, replayed in pairs:
        if recorded == replayed:
            continue
        times = [time_of(one) for one in (recorded, replayed) if one is not None]
        if min(times) > now_ns:
            return None
        first = _first_byte(_data(recorded), _data(replayed))
        return Difference(min(times), topic, _shown(recorded, first), _shown(replayed, first))
    return None


def _records(wire: Compared, topic: str, block: bytearray) -> Iterator[Traffic]:
    try:
        yield from unpack(wire.schema, topic, bytes(block))
    except ValueError:
        return


def _data(record: Traffic | None) -> bytes:
    if isinstance(record, SpiTransaction):
        return record.mosi + record.miso
    if isinstance(record, I2cTransaction):
        return record.transfer.written + record.transfer.read
    return record.data if isinstance(record, UartChunk | CanMessage | LinePiece) else b""


def _first_byte(one: bytes, other: bytes) -> int:
    """Where two byte strings begin to differ; the shorter one's length when they do not before."""
    pairs = zip(one, other, strict=False)
    return next((k for k, (a, b) in enumerate(pairs) if a != b), min(len(one), len(other)))


def _shown(record: Traffic | None, first: int) -> str:
    match record:
        case None:
            return "nothing"
        case PinEdge():
            return f"{record.time_ns / 1e9:.9f} s, level {'high' if record.level else 'low'}"
        case SpiTransaction():
            duration = f"{record.end_ns - record.start_ns} ns"
            answer = shown_bytes(record.miso, first - len(record.mosi))
            sent = shown_bytes(record.mosi, first)
            return f"{record.start_ns / 1e9:.9f} s, {duration}, MOSI {sent}, MISO {answer}"
        case I2cTransaction():
            return shown_transfer(record.transfer, first)
        case LineCut() | Mark():
            return f"{time_of(record) / 1e9:.9f} s"
        case _:
            name = _can_name(record) if isinstance(record, CanMessage) else _rate(record)
            return f"ends at {record.end_ns / 1e9:.9f} s, {name}{shown_bytes(record.data, first)}"


def _can_name(record: CanMessage) -> str:
    sender = "" if record.sender is None else f"from {record.sender}, "
    return f"identifier 0x{record.identifier:X}, {sender}"


def _rate(record: UartChunk | LinePiece) -> str:
    return "" if record.baud is None else f"{record.baud} baud, "


def shown_transfer(done: I2cTransfer, first: int = 0) -> str:
    """An I²C transaction in words; `first`: byte that is to be seen, of those written and then read."""
    written, read = shown_bytes(done.written, first), shown_bytes(done.read, first - len(done.written))
    sent = f", writes {written} ({done.acknowledged} acknowledged)" if done.written else ""
    came = f", reads {done.asked} bytes{': ' if read else ''}{read}" if done.asked else ""
    refused = "" if done.refusal is None else f", {done.refusal.name.lower().replace('_', ' ')}"
    return f"{done.start_ns / 1e9:.9f} s, address 0x{done.address:02X}{sent}{came}{refused}"


def shown_bytes(data: bytes, notable: int = 0) -> str:
    """Bytes in hex, as many as a line bears, among them the one at `notable`."""
    if len(data) <= SHOWN_BYTES:
        return data.hex(" ")
    begin = max(0, min(notable - SHOWN_BEFORE, len(data) - SHOWN_BYTES))
    before = f"byte {begin} on: " if begin else ""
    return f"{before}{data[begin : begin + SHOWN_BYTES].hex(' ')} … ({len(data)} bytes)"
