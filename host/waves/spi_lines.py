r"""SPI: clock, both data lines and every chip select, from transactions.

    CS   ‾‾\__________________________/‾‾‾      mode 0, 1: clock idles low; 2, 3: high
    SCK  ‾‾‾\_/‾\_/‾ … ‾\_/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾      mode 0, 2: sampled on the first edge of a bit, 1, 3: on the
    data --X 7 X 6 … X 0 X------------               second; bits change half a clock before

Clock k begins ⌊k·10⁹/f⌋ ns after chip select fell, and later by the pauses before it; most significant bit
first. Words and the pauses between them are those of the chip (`hal.emulated.spi.SpiTiming`); what a
transaction took longer than that is shared evenly among the gaps between its words. Between transactions
nobody drives MISO; MOSI is drawn low there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from hal.emulated.spi import SpiTiming
from hal.emulated.virtual_time import SECOND
from host.capture.blocks import SpiTransaction, Traffic
from host.record.errors import UserError
from host.waves.lines import Edge, Level, Unit

SCK, MOSI, MISO, FIRST_SELECT = range(4)


class SpiLines:
    """One bus with all its chip selects."""

    kind = "spi"

    def __init__(self, name: str, devices: Mapping[str, SpiTiming], mode: int) -> None:
        self.name = name
        self.mode = mode
        self._timings = dict(devices)
        self._selects = {device: FIRST_SELECT + k for k, device in enumerate(devices)}
        self.lines = [f"{name}_sck", f"{name}_mosi", f"{name}_miso", *(f"{name}_cs_{d}" for d in devices)]
        self.idle: list[Level] = [mode >> 1, 0, "z", *(1 for _ in devices)]
        self.lanes = [list(range(len(self.lines)))]
        self.gap_ns = min(SECOND // (4 * timing.frequency_hz) for timing in devices.values())

    def units(self, record: Traffic) -> list[Unit]:
        """A transaction."""
        assert isinstance(record, SpiTransaction)
        return [Unit(record.start_ns, record.end_ns, 0, record)]

    def edges(self, unit: Unit) -> list[Edge]:
        """Chip select, then clock and data bit by bit."""
        record: SpiTransaction = unit.content
        device = record.bus.split(".", 1)[1]
        select, rate = self._selects[device], 2 * self._timings[device].frequency_hz
        idle, shift = self.mode >> 1, 1 - (self.mode & 1)
        edges = [Edge(record.start_ns, select, 0)]
        mosi, miso = record.mosi, record.miso
        for place, (base, clocks) in enumerate(self._bytes(record, self._timings[device])):
            for bit in range(8):
                half, down = 2 * (clocks + bit), 7 - bit
                begin = base + half * SECOND // rate
                edges.append(Edge(begin, MOSI, mosi[place] >> down & 1))
                edges.append(Edge(begin, MISO, miso[place] >> down & 1))
                edges.append(Edge(base + (half + shift) * SECOND // rate, SCK, 1 - idle))
                edges.append(Edge(base + (half + shift + 1) * SECOND // rate, SCK, idle))
        end = record.end_ns
        edges += [Edge(end, select, 1), Edge(end, MISO, "z"), Edge(end, MOSI, 0)]
        return edges

    def facts(self) -> dict[str, Any]:
        """Clock and mode."""
        clocks = {device: timing.frequency_hz for device, timing in self._timings.items()}
        return {"clock_hz": clocks, "mode": self.mode}

    def _bytes(self, record: SpiTransaction, timing: SpiTiming) -> Iterator[tuple[int, int]]:
        """For each byte the instant from which its clocks are counted, and how many come before it."""
        length, word = len(record.mosi), timing.bits_per_word // 8
        if length % word:
            timing, word = replace(timing, bits_per_word=8), 1
        gaps = length // word - 1
        surplus = self._surplus(record, timing) if length else 0
        for place in range(length):
            before = place // word
            spread = surplus * before // gaps if before else 0
            base = record.start_ns + timing.setup_ns + before * timing.stall_ns + spread
            yield base, 8 * place + before * timing.stall_clocks

    def _surplus(self, record: SpiTransaction, timing: SpiTiming) -> int:
        """How much longer a transaction took than its timing says, ns."""
        length, took = len(record.mosi), record.end_ns - record.start_ns
        expected = timing.duration_ns(length)
        if took < expected:
            raise UserError(
                f"{record.bus} at {record.start_ns / 1e9:.9f} s: {length} bytes in {took} ns; at"
                f" {timing.frequency_hz} Hz they take {expected} ns."
                f" Name the right clock, e.g. --rate {self.name}={8 * length * SECOND // max(took, 1)}"
            )
        return took - expected
