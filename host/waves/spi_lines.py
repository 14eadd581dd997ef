r"""SPI: clock, both data lines and every chip select, from transactions.

    CS   ‾‾\__________________________/‾‾‾      mode 0, 1: clock idles low; 2, 3: high
    SCK  ‾‾‾\_/‾\_/‾ … ‾\_/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾      mode 0, 2: sampled on the first edge of a bit, 1, 3: on the
    data --X 7 X 6 … X 0 X------------               second; bits change half a clock before

Bit k of a transaction begins ⌊k·10⁹/f⌋ ns after chip select fell, most significant bit first. What the
transaction took longer than its clocks is the pause between its bytes and is shared evenly among them.
Between transactions nobody drives MISO; MOSI is drawn low there.
"""

from __future__ import annotations

from typing import Any

from hal.emulated.virtual_time import SECOND
from host.capture.blocks import SpiTransaction, Traffic
from host.record.errors import UserError
from host.waves.lines import Edge, Level, Unit

SCK, MOSI, MISO, FIRST_SELECT = range(4)


class SpiLines:
    """One bus with all its chip selects."""

    kind = "spi"

    def __init__(self, name: str, devices: list[str], clock_hz: int, mode: int) -> None:
        self.name = name
        self.clock_hz = clock_hz
        self.mode = mode
        self._idle_clock = mode >> 1
        self._late = mode & 1
        """Whether data are sampled on the second edge of a bit (CPHA = 1)."""
        self._selects = {device: FIRST_SELECT + k for k, device in enumerate(devices)}
        self.lines = [f"{name}_sck", f"{name}_mosi", f"{name}_miso", *(f"{name}_cs_{d}" for d in devices)]
        self.idle: list[Level] = [self._idle_clock, 0, "z", *(1 for _ in devices)]
        self.lanes = [list(range(len(self.lines)))]
        self.gap_ns = SECOND // (4 * clock_hz)

    def units(self, record: Traffic) -> list[Unit]:
        """A transaction."""
        assert isinstance(record, SpiTransaction)
        return [Unit(record.start_ns, record.end_ns, 0, record)]

    def edges(self, unit: Unit) -> list[Edge]:
        """Chip select, then clock and data bit by bit."""
        record: SpiTransaction = unit.content
        select = self._selects[record.bus.split(".", 1)[1]]
        start, count = record.start_ns, len(record.mosi)
        pauses = self._pauses(record)
        active, idle = 1 - self._idle_clock, self._idle_clock
        first, second = (active, idle)
        shift = 0 if self._late else 1  # in half clocks: the first edge of a bit after the bit's beginning
        edges = [Edge(start, select, 0)]
        for place in range(count):
            base = start + (pauses * place // (count - 1) if place else 0)
            out, back = record.mosi[place], record.miso[place]
            for bit in range(8):
                half = 2 * (8 * place + bit)
                begin = base + half * SECOND // (2 * self.clock_hz)
                down = 7 - bit
                edges.append(Edge(begin, MOSI, out >> down & 1))
                edges.append(Edge(begin, MISO, back >> down & 1))
                edges.append(Edge(base + (half + shift) * SECOND // (2 * self.clock_hz), SCK, first))
                edges.append(Edge(base + (half + shift + 1) * SECOND // (2 * self.clock_hz), SCK, second))
        end = record.end_ns
        edges += [Edge(end, select, 1), Edge(end, MISO, "z"), Edge(end, MOSI, 0)]
        return edges

    def facts(self) -> dict[str, Any]:
        """Clock and mode."""
        return {"clock_hz": self.clock_hz, "mode": self.mode}

    def _pauses(self, record: SpiTransaction) -> int:
        """Time in a transaction that is not clocks, ns."""
        count = len(record.mosi)
        clocks_ns = 8 * count * SECOND // self.clock_hz
        pauses = record.end_ns - record.start_ns - clocks_ns
        if pauses < 0:
            raise UserError(
                f"{record.bus} at {record.start_ns / 1e9:.9f} s: {count} bytes in"
                f" {record.end_ns - record.start_ns} ns; at {self.clock_hz} Hz they take {clocks_ns} ns."
                f" Name the right clock, e.g. --rate {self.name}={2 * self.clock_hz}"
            )
        return pauses
