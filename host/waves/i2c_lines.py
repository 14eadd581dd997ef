r"""I²C: clock and data, from transactions.

A start condition, a repeated one and a stop take one clock each, every byte nine; the address counts as a
byte. All instants are counted from the start condition, so that nothing is rounded twice. SDA falls at the
start of the transaction and rises at its end:

           | start   | bit ……… | bit …   | repeated start    | stop      |
    SCL  ‾‾‾‾‾‾‾‾‾‾‾‾‾\_____/‾‾‾‾\_____/‾ … \_______/‾‾‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾‾
    SDA  ‾‾‾\___________X 7 ……… X 6 …      …/‾‾‾‾‾‾‾‾‾‾\________________/‾‾‾

A bit's clock is low for 6/10 of its time; SDA changes at 2/10. What a transaction took longer than its clocks
is the clock held low by the slave after its address (shared evenly when it was addressed twice).
"""

from __future__ import annotations

from typing import Any

from hal.emulated.i2c import BYTE_CLOCKS, I2cTransfer
from hal.emulated.virtual_time import SECOND
from hal.errors import ErrorKind
from host.capture.blocks import I2cTransaction, Traffic
from host.waves.lines import Edge, Level, Unit

SCL, SDA = 0, 1
TENTHS = 10


class I2cLines:
    """One bus."""

    kind = "i2c"

    def __init__(self, name: str, clock_hz: int) -> None:
        self.name = name
        self.clock_hz = clock_hz
        self.lines = [f"{name}_scl", f"{name}_sda"]
        self.idle: list[Level] = [1, 1]
        self.lanes = [[SCL, SDA]]
        self.gap_ns = SECOND // (5 * clock_hz)

    def units(self, record: Traffic) -> list[Unit]:
        """A transaction."""
        assert isinstance(record, I2cTransaction)
        transfer = record.transfer
        return [Unit(transfer.start_ns, transfer.end_ns, 0, transfer)]

    def edges(self, unit: Unit) -> list[Edge]:
        """From start condition to stop condition; less when it was broken off."""
        transfer: I2cTransfer = unit.content
        pen = _Pen(transfer, self.clock_hz)
        _draw(pen, transfer)
        return pen.finished()

    def facts(self) -> dict[str, Any]:
        """Clock."""
        return {"clock_hz": self.clock_hz}


def _draw(pen: _Pen, transfer: I2cTransfer) -> None:
    count, refusal = len(transfer.written), transfer.refusal
    twice = _addressed_twice(transfer)
    missed = refusal is ErrorKind.ADDRESS_NACK
    timeout = refusal is ErrorKind.TIMEOUT
    halves = twice and refusal is None
    first_hold = pen.spare // 2 if halves else 0 if timeout and twice else pen.spare
    pen.start()
    pen.byte(transfer.address << 1 | (not count and transfer.asked > 0), acknowledged=twice or not missed)
    if not missed or twice:
        pen.hold(first_hold)
        if timeout and not twice:
            return
        for place, value in enumerate(transfer.written):
            pen.byte(value, acknowledged=place < transfer.acknowledged or refusal is ErrorKind.OTHER)
    if twice:
        pen.start_again()
        pen.byte(transfer.address << 1 | 1, acknowledged=not missed)
        pen.hold(pen.spare - first_hold)
        if timeout:
            return
    if not missed and refusal is not ErrorKind.DATA_NACK:
        for place in range(transfer.asked):
            value = transfer.read[place] if place < len(transfer.read) else 0xFF
            pen.byte(value, acknowledged=place < transfer.asked - 1)
    pen.stop()


def _addressed_twice(transfer: I2cTransfer) -> bool:
    """Whether it went on to the repeated start."""
    count = len(transfer.written)
    return count > 0 and transfer.asked > 0 and transfer.acknowledged == count


class _Pen:
    """Draws clock by clock."""

    def __init__(self, transfer: I2cTransfer, clock_hz: int) -> None:
        self._start = transfer.start_ns
        self._end = transfer.end_ns
        self._clock_hz = clock_hz
        self._tenths = 0
        self._edges: list[Edge] = []
        broken = transfer.refusal is ErrorKind.OTHER
        clocked = _clocks(transfer) * SECOND // clock_hz
        self.spare = 0 if broken else max(0, self._end - self._start - clocked)
        """Time that is not clocks, ns."""

    def start(self) -> None:
        """Start condition, from idle lines."""
        self._to(0, SDA, 0)
        self._tenths += TENTHS

    def start_again(self) -> None:
        """Repeated start."""
        self._to(0, SCL, 0)
        self._to(1, SDA, 1)
        self._to(4, SCL, 1)
        self._to(7, SDA, 0)
        self._tenths += TENTHS

    def byte(self, value: int, acknowledged: bool) -> None:
        """Eight bits, the most significant first, and the acknowledge."""
        for shift in range(7, -1, -1):
            self._bit(value >> shift & 1)
        self._bit(0 if acknowledged else 1)

    def hold(self, duration_ns: int) -> None:
        """The slave holds the clock low."""
        if duration_ns:
            self._to(0, SCL, 0)
            self._start += duration_ns

    def stop(self) -> None:
        """Stop condition; the lines are idle at its end."""
        self._to(0, SCL, 0)
        self._to(2, SDA, 0)
        self._to(6, SCL, 1)
        self._to(10, SDA, 1)
        self._tenths += TENTHS

    def finished(self) -> list[Edge]:
        """All edges up to the end; whoever broke off lets go of the data line, then of the clock."""
        kept = [edge for edge in self._edges if edge.time_ns <= self._end]
        levels = {edge.line: edge.level for edge in kept}
        if not levels.get(SDA, 1):
            before = self._end - SECOND // (5 * self._clock_hz)
            kept.append(Edge(max(kept[-1].time_ns, before), SDA, 1))
        if not levels.get(SCL, 1):
            kept.append(Edge(self._end, SCL, 1))
        return kept

    def _bit(self, level: int) -> None:
        self._to(0, SCL, 0)
        self._to(2, SDA, level)
        self._to(6, SCL, 1)
        self._tenths += TENTHS

    def _to(self, tenths: int, line: int, level: Level) -> None:
        time_ns = self._start + (self._tenths + tenths) * SECOND // (TENTHS * self._clock_hz)
        self._edges.append(Edge(time_ns, line, level))


def _clocks(transfer: I2cTransfer) -> int:
    """Clocks of a transaction that was not broken off by a reset."""
    count = len(transfer.written)
    address = 1 + BYTE_CLOCKS
    again = address if _addressed_twice(transfer) else 0
    stop = 1
    match transfer.refusal:
        case ErrorKind.ADDRESS_NACK:
            return address + (BYTE_CLOCKS * count + again if again else 0) + stop
        case ErrorKind.DATA_NACK:
            return address + BYTE_CLOCKS * count + stop
        case ErrorKind.TIMEOUT:
            return address + (BYTE_CLOCKS * count + again if again else 0)
        case _:
            return address + BYTE_CLOCKS * (count + transfer.asked) + again + stop
