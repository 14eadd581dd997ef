"""Levels of the lines of many buses in the order of time, as a VCD file.

Edges of different buses come interleaved and traffic is recorded later than it begins, so nothing is written
before it is certain that nothing earlier can come (`Recording.begins`). Memory holds one window of traffic
and a few thousand units of edges, however long the capture is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from vcd import VCDWriter

from host.record.errors import UserError
from host.waves.lines import Tracer, Unit
from host.waves.recording import FAR, Recording
from host.waves.sheet import Sheet
from host.waves.wiring import BusKey, board_of, chosen, given_rates, tracers

SCOPE = "board"
UNITS_AT_ONCE = 2_000
NS = 1_000_000_000
SHARE_OF_LOOKING = 0.2
"""Of the progress, for the reading before the drawing."""

Progress = Callable[[float, float], None]


@dataclass(frozen=True, slots=True)
class WavesRequest:
    """What is to be drawn. `from_s`, `to_s`: virtual time."""

    capture: Path
    target: Path
    buses: list[str] = field(default_factory=list)
    rates: list[str] = field(default_factory=list)
    from_s: float = 0.0
    to_s: float | None = None


def draw(request: WavesRequest, progress: Progress | None = None) -> dict[str, Any]:
    """Write the levels of the lines in a stretch of a capture; returns what was drawn. Raises UserError.

    The file is there whole or not at all.
    """
    if request.target.exists():
        raise UserError(f"-o {request.target}: exists already; name a new file")
    _check_stretch(request)
    to_ns = FAR if request.to_s is None else _nanoseconds(request.to_s)
    recording = Recording(request.capture, _nanoseconds(request.from_s), to_ns)
    begin_ns, end_ns = _stretch(request, recording.end_ns)
    buses = chosen(recording.buses, request.buses)
    rates = given_rates(request.rates, recording.buses)
    board = board_of(recording.manifest)
    tell = _teller(progress, recording.end_ns)
    looking = tracers(buses, board, rates)
    later = recording.begins(_by_bus(looking), lambda now: tell(SHARE_OF_LOOKING * now))
    part = request.target.with_name(request.target.name + ".part")
    try:
        with part.open("w", encoding="ascii") as file:
            drawing = Drawing(file, tracers(buses, board, rates), begin_ns, end_ns)
            drawing.run(recording, later, tell)
        part.replace(request.target)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise UserError(f"-o {request.target}: cannot be written: {error.strerror}") from None
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    return {
        "capture": str(request.capture),
        "file": str(request.target),
        "bytes": request.target.stat().st_size,
        "from_s": begin_ns / NS,
        "to_s": end_ns / NS,
        "recorded_s": recording.end_ns / NS,
        **drawing.facts(),
    }


class Drawing:
    """A VCD file under way."""

    def __init__(self, file: IO[str], drawn: list[Tracer], begin_ns: int, end_ns: int) -> None:
        self._writer = VCDWriter(file, timescale="1 ns", date="", init_timestamp=begin_ns)
        self._begin_ns = begin_ns
        self._end_ns = end_ns
        self._tracers = drawn
        self._changes = 0
        self._gap_ns = max(tracer.gap_ns for tracer in drawn)
        self._sheets: dict[BusKey, list[Sheet]] = {}
        for tracer in drawn:
            variables = [
                self._writer.register_var(SCOPE, name, "wire", size=1, init=level)
                for name, level in zip(tracer.lines, tracer.idle, strict=True)
            ]
            lanes = range(len(tracer.lanes))
            self._sheets[tracer.name, tracer.kind] = [Sheet(tracer, variables, lane) for lane in lanes]

    def run(self, recording: Recording, later: list[int], tell: Callable[[float], None]) -> None:
        """Draw everything."""
        sheets = [sheet for lanes in self._sheets.values() for sheet in lanes]
        windows = recording.windows(_by_bus(self._tracers))
        for (now_ns, units), next_ns in zip(windows, later, strict=True):
            for bus, some in units.items():
                for sheet in self._sheets[bus]:
                    sheet.take([unit for unit in some if unit.lane == sheet.lane])
            if not self._draw_up_to(min(next_ns, self._end_ns), sheets):
                break
            tell(SHARE_OF_LOOKING * recording.end_ns + (1 - SHARE_OF_LOOKING) * now_ns)
        self._draw_up_to(self._end_ns, sheets)
        self._write(self._end_ns, sheets)
        self._writer.close(self._end_ns)

    def facts(self) -> dict[str, Any]:
        """What was drawn."""
        buses = []
        for tracer in self._tracers:
            sheets = self._sheets[tracer.name, tracer.kind]
            buses.append(
                {
                    "name": tracer.name,
                    "kind": tracer.kind,
                    "lines": tracer.lines,
                    "units": sum(sheet.drawn for sheet in sheets),
                    "cut_short": sum(sheet.cut_short for sheet in sheets),
                    **tracer.facts(),
                }
            )
        return {"changes": self._changes, "buses": buses}

    def _draw_up_to(self, time_ns: int, sheets: list[Sheet]) -> bool:
        """Draw and write whatever begins before `time_ns`; False: the stretch is over."""
        for unit, sheet in self._ready(time_ns, sheets):
            if unit.end_ns >= self._begin_ns:
                sheet.draw(unit)
                sheet.drawn += 1
        self._write(time_ns - self._gap_ns, sheets)
        return time_ns < self._end_ns

    def _ready(self, time_ns: int, sheets: list[Sheet]) -> Iterator[tuple[Unit, Sheet]]:
        """Units that begin before `time_ns`; in between, what is certain is written."""
        ready = []
        for sheet in sheets:
            ready += [(unit, sheet) for unit in sheet.waiting if unit.begin_ns < time_ns]
            sheet.waiting = [unit for unit in sheet.waiting if unit.begin_ns >= time_ns]
        ready.sort(key=lambda pair: pair[0].begin_ns)
        for number, pair in enumerate(ready):
            if number % UNITS_AT_ONCE == 0:
                self._write(pair[0].begin_ns - self._gap_ns, sheets)
            yield pair

    def _write(self, time_ns: int, sheets: list[Sheet]) -> None:
        """All edges before `time_ns`."""
        edges = []
        for sheet in sheets:
            variables = sheet.variables
            edges += [
                (edge.time_ns, variables[edge.line], edge.level) for edge in sheet.written_before(time_ns)
            ]
        edges.sort(key=lambda edge: edge[0])
        change, begin_ns = self._writer.change, self._begin_ns
        for at_ns, variable, level in edges:
            change(variable, at_ns if at_ns > begin_ns else begin_ns, level)
        self._changes += len(edges)


def _by_bus(drawn: list[Tracer]) -> dict[BusKey, Tracer]:
    return {(tracer.name, tracer.kind): tracer for tracer in drawn}


def _check_stretch(request: WavesRequest) -> None:
    from_s, to_s = request.from_s, request.to_s
    good_end = to_s is None or (math.isfinite(to_s) and to_s > from_s)
    if not (math.isfinite(from_s) and from_s >= 0 and good_end):
        raise UserError(
            f"--from {from_s:g} --to {to_s}: must be 0 or more and rise, e.g. --from 60 --to 60.1"
        )


def _stretch(request: WavesRequest, recorded_ns: int) -> tuple[int, int]:
    """From and to in ns, inside the recording."""
    from_s, to_s = request.from_s, request.to_s
    if from_s * NS >= recorded_ns:
        raise UserError(
            f"--from {from_s:g}: capture {request.capture} ends at {recorded_ns / NS:g} s; choose earlier"
        )
    end_ns = recorded_ns if to_s is None else min(_nanoseconds(to_s), recorded_ns)
    return _nanoseconds(from_s), end_ns


def _nanoseconds(time_s: float) -> int:
    return round(min(time_s * NS, float(FAR)))


def _teller(progress: Progress | None, recorded_ns: int) -> Callable[[float], None]:
    def tell(time_ns: float) -> None:
        if progress is not None:
            progress(time_ns / NS, recorded_ns / NS)

    return tell
