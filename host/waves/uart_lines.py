"""UART: both lines of a port, byte by byte.

A byte is a start bit (low), eight bits from the least significant on, and a stop bit (high). Bytes sent back
to back form a run; bit k of a run that begins at t₀ begins at t₀ + ⌊k·10⁹/baud⌋. With a fault at work there
may be a parity bit before the stop bit; a stop bit that was found low is drawn low for three quarters of it.

A capture tells the rate of the line into the processor with every piece, and since format 4 that of the line
out of it. Of the latter an older one has only the ends of pieces; its rate is taken to be that of the other
direction, as far as something has come in by then, and the board's before. A piece that would begin before
the end of the one before it was sent faster: at the lowest known or usual rate at which it fits.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from hal.emulated.uart_bytes import FORMS, FRAME, BrokenFrames, ParityFrames
from hal.emulated.virtual_time import SECOND
from host.capture.blocks import LineCut, LinePiece, Traffic, UartChunk
from host.record.errors import UserError
from host.waves.lines import Edge, Level, Unit

RX, TX = 0, 1
PARITY, BROKEN = FORMS.index(ParityFrames), FORMS.index(BrokenFrames)
USUAL_RATES = (4_800, 9_600, 19_200, 38_400, 57_600, 115_200, 230_400, 460_800, 921_600, 3_000_000)


class Byte(NamedTuple):
    """Byte number `place` of a run."""

    value: int
    start_ns: int
    place: int
    baud: int
    form: int = 0
    """Place in `FORMS`."""


class Run(NamedTuple):
    """What is known of the bytes that were sent back to back before."""

    start_ns: int
    length: int
    baud: int
    end_ns: int


class UartLines:
    """One port. `fixed`: the rate was given and holds for what the capture does not tell."""

    kind = "uart"
    gap_ns = 0

    def __init__(self, name: str, baud: int, fixed: bool) -> None:
        self.name = name
        self.lines = [f"{name}_rx", f"{name}_tx"]
        self.idle: list[Level] = [1, 1]
        self.lanes = [[RX], [TX]]
        self._baud = baud
        self._fixed = fixed
        self._runs: list[Run | None] = [None, None]
        self._rates: tuple[set[int], set[int]] = (set(), set())
        self._told = False

    def units(self, record: Traffic) -> list[Unit]:
        """Bytes, or the end of what was told."""
        if isinstance(record, LineCut):
            return [Unit(record.begin_ns, record.begin_ns, RX, None)]
        if isinstance(record, LinePiece):
            if not self._fixed:
                self._baud = record.baud
            self._rates[RX].add(record.baud)
            return _bytes(RX, record.start_ns, record.first, record.baud, record.data, record.form)
        assert isinstance(record, UartChunk)
        if not record.data:
            return []
        return self._chunk(TX if record.direction == "tx" else RX, record)

    def edges(self, unit: Unit) -> list[Edge]:
        """Start bit, eight bits, stop bit."""
        byte: Byte = unit.content
        bits = FORMS[byte.form].frame_bits
        frame = byte.value << 1 | 1 << (bits - 1)
        if byte.form == PARITY:
            frame |= (byte.value.bit_count() & 1) << (bits - 2)
        if byte.form == BROKEN:
            frame ^= 1 << (bits - 1)
        first = bits * byte.place
        edges, level = [], 1
        for bit in range(bits):
            wanted = frame >> bit & 1
            if wanted != level:
                level = wanted
                edges.append(Edge(byte.start_ns + (first + bit) * SECOND // byte.baud, unit.lane, level))
        if not level:
            high = (4 * (first + bits) - 1) * SECOND // (4 * byte.baud)
            edges.append(Edge(byte.start_ns + high, unit.lane, 1))
        return edges

    def facts(self) -> dict[str, Any]:
        """Every rate that was met, and how that of the line out is known."""
        guessed = "recorded" if self._told else "taken from the board and the other direction"
        told = "given" if self._fixed else guessed
        return {
            "rx_baud": sorted(self._rates[RX]),
            "tx_baud": sorted(self._rates[TX]),
            "tx_baud_is": told,
        }

    def _chunk(self, lane: int, record: UartChunk) -> list[Unit]:
        """Bytes of which the end of the last is known, and since format 4 the rate."""
        count, before = len(record.data), self._runs[lane]
        told = None if self._fixed else record.baud
        baud = self._baud if told is None else told
        self._told |= told is not None
        if before is not None:
            baud = self._fitting(record, before.end_ns) if told is None else told
            begin = record.end_ns - _frames_ns(count, baud)
            whole_end = before.start_ns + _frames_ns(before.length + count, baud)
            if before.baud == baud and begin - before.end_ns in (0, 1) and whole_end == record.end_ns:
                self._runs[lane] = Run(before.start_ns, before.length + count, baud, record.end_ns)
                return _bytes(lane, before.start_ns, before.length, baud, record.data)
        begin = record.end_ns - _frames_ns(count, baud)
        self._rates[lane].add(baud)
        self._runs[lane] = Run(begin, count, baud, record.end_ns)
        return _bytes(lane, begin, 0, baud, record.data)

    def _fitting(self, record: UartChunk, free_ns: int) -> int:
        """The rate at which a piece fits between the end of the one before and its own."""

        def fits(baud: int) -> bool:
            return record.end_ns - _frames_ns(len(record.data), baud) >= free_ns - 1

        if fits(self._baud):
            return self._baud
        if self._fixed:
            raise UserError(
                f"{self.name} at {record.end_ns / 1e9:.9f} s: {len(record.data)} bytes do not fit behind"
                f" those before at {self._baud} baud; --rate {self.name}={self._baud} cannot be right for all"
            )
        known = sorted({*self._rates[RX], *self._rates[TX], *USUAL_RATES})
        fitting = [baud for baud in known if baud > self._baud and fits(baud)]
        return fitting[0] if fitting else self._baud


def _frames_ns(count: int, baud: int) -> int:
    return count * FRAME // baud


def _bytes(lane: int, start_ns: int, first: int, baud: int, data: bytes, form: int = 0) -> list[Unit]:
    frame = FORMS[form].frame
    return [
        Unit(
            start_ns + place * frame // baud,
            start_ns + (place + 1) * frame // baud,
            lane,
            Byte(value, start_ns, place, baud, form),
        )
        for place, value in enumerate(data, first)
    ]
