"""A capture, bus by bus and window by window.

It is read twice, of a short stretch only the chunks that hold it: the first time to learn what buses it
holds, when each window's traffic begins (a long piece on a slow line is recorded at its end, windows after
its beginning), and how far it goes; the second time to draw. What is kept in between is one number a window.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from host.capture.blocks import Traffic, time_of, unpack
from host.capture.reader import CaptureReader, Window
from host.capture.stretch import StretchReader
from host.record.errors import UserError
from host.waves.lines import Tracer, Unit
from host.waves.wiring import BusKey, RecordedBus, bus_of

FAR = 1 << 62

Progress = Callable[[int], None]
"""How far reading has got, ns."""


MARGIN_NS = 10_000_000_000
"""Around the stretch that is drawn: a piece on a slow line is recorded at its end."""


class Recording:
    """The buses of one capture, and its traffic from `from_ns` to `to_ns`; of a finished capture only that is
    read. Raises UserError for a file that is none, or is damaged."""

    def __init__(self, path: Path, from_ns: int = 0, to_ns: int = FAR) -> None:
        self._path = path
        self._stretch = (max(0, from_ns - MARGIN_NS), to_ns + MARGIN_NS)
        self.end_ns = 0
        reader = self._reader()
        buses: dict[BusKey, RecordedBus] = {}
        for window in reader.windows():
            self.end_ns = max(self.end_ns, window.end_ns)
            self._learn(reader, window, buses)
        for topic in reader.raw_topics:
            self._bus(buses, topic)
        self.manifest = reader.manifest
        self.buses = sorted(buses.values(), key=lambda bus: (bus.kind, bus.name))

    def windows(self, tracers: Mapping[BusKey, Tracer]) -> Iterator[tuple[int, dict[BusKey, list[Unit]]]]:
        """(end in ns, units of each tracer) window by window."""
        reader = self._reader()
        for window in reader.windows():
            records: dict[BusKey, list[Traffic]] = {}
            for topic, block in window.raw.items():
                bus = bus_of(topic)
                if bus is not None and bus in tracers:
                    records.setdefault(bus, []).extend(self._unpacked(reader, topic, block))
            units = {}
            for bus, told in records.items():
                tracer = tracers[bus]
                told.sort(key=time_of)
                units[bus] = [unit for record in told for unit in self._units(tracer, record)]
            yield window.end_ns, units

    def _reader(self) -> CaptureReader:
        return StretchReader(self._path, *self._stretch)

    def begins(self, tracers: Mapping[BusKey, Tracer], progress: Progress) -> list[int]:
        """For each window the earliest beginning of a unit in those behind it, ns."""
        earliest = []
        for end_ns, units in self.windows(tracers):
            begins = [unit.begin_ns for some in units.values() for unit in some]
            earliest.append(min(begins, default=FAR))
            progress(end_ns)
        behind, later = FAR, []
        for first in reversed(earliest):
            later.append(behind)
            behind = min(behind, first)
        return later[::-1]

    def _learn(self, reader: CaptureReader, window: Window, buses: dict[BusKey, RecordedBus]) -> None:
        for topic, block in window.raw.items():
            bus = self._bus(buses, topic)
            if bus is not None and bus.kind == "can":
                for record in self._unpacked(reader, topic, block):
                    bus.note(record)

    def _bus(self, buses: dict[BusKey, RecordedBus], topic: str) -> RecordedBus | None:
        found = bus_of(topic)
        if found is None:
            return None
        bus = buses.setdefault(found, RecordedBus(*found))
        bus.add_topic(topic)
        return bus

    def _unpacked(self, reader: CaptureReader, topic: str, block: bytes) -> list[Traffic]:
        schema = reader.raw_schema(topic)
        assert schema is not None
        try:
            return list(unpack(schema, topic, block))
        except ValueError as error:
            raise self._damaged(error) from None

    def _units(self, tracer: Tracer, record: Traffic) -> list[Unit]:
        try:
            return tracer.units(record)
        except ValueError as error:
            raise self._damaged(error) from None

    def _damaged(self, error: ValueError) -> UserError:
        return UserError(f"capture {self._path}: damaged: {error}")
