"""Import: streams are inspected, put in order of time and written, portion by portion."""

from __future__ import annotations

import heapq
import json
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from boards.hints import did_you_mean
from host.capture.topics import IMPORT_FORMAT
from host.importers.findings import Findings
from host.importers.import_writer import ImportWriter
from host.importers.inspection import Inspection
from host.importers.kinds import KINDS, OPTIONS
from host.importers.overlap import Overlap
from host.importers.request import ImportRequest, ImportResult, Recording, Task
from host.importers.series import Portion, Rows, Series, Stream
from host.importers.time_base import NS, leap_seconds_at, unix_from_gps, utc_text
from host.importers.topics import ACCURACIES, FORCES, PLACE, RATES, VELOCITY
from host.importers.turn_check import TurnCheck
from host.importers.unit_checks import InertialUnits, MotionUnits
from host.importers.units import Units
from host.record.errors import UserError
from host.record.manifest import versions


def import_recording(request: ImportRequest) -> ImportResult:
    """Import. Raises UserError for whatever the user can mend; then nothing is left behind."""
    if request.kind not in KINDS:
        raise UserError(f"import {request.kind}: no such kind; {did_you_mean(request.kind, KINDS)}")
    _check_options(request)
    _check_paths(request)
    begin = time.perf_counter()
    findings, units = Findings(), Units(request.units)
    task = Task(request, findings, units, _meter(request))
    recording = KINDS[request.kind](task)
    units.check_used(request.kind)
    accuracy = _accuracy(request.accuracy)
    turns, overlap = TurnCheck(findings), Overlap(findings)
    checked = [_Checked(stream, findings) for stream in recording.streams]
    waiting = [(portion.first_ns, i, portion) for i, one in enumerate(checked) if (portion := one.next())]
    if not waiting:
        told = "".join(f"\n- {line}" for line in findings.lines())
        names = ", ".join(file.name for file in request.files)
        raise UserError(f"import {request.kind}: {names}: nothing in it can be used{told}")
    heapq.heapify(waiting)
    origin_ns = waiting[0][0] // NS * NS
    writer = ImportWriter(request.target, _manifest(request, recording, origin_ns), origin_ns)
    try:
        while waiting:
            _, i, portion = heapq.heappop(waiting)
            _write(writer, portion, accuracy)
            if isinstance(portion, Rows):
                turns.take(portion)
                overlap.take(portion)
            following = checked[i].next()
            if following is not None:
                heapq.heappush(waiting, (following.first_ns, i, following))
        turns.finish()
        uses = _uses(writer.counts, overlap.finish())
        for line in findings.lines():
            writer.event("import", line)
        left_out = sum(one.left_out for one in checked)
        summary = {"duration_s": repr((writer.last_ns + 1) / NS), "findings": json.dumps(findings.to_list())}
        writer.close(summary)
    except OSError as error:
        writer.abandon()
        raise UserError(f"-o {request.target}: cannot be written: {error.strerror}") from None
    except BaseException:
        writer.abandon()
        raise
    return ImportResult(
        capture=request.target,
        kind=request.kind,
        duration_s=writer.last_ns / NS,
        begins=utc_text(origin_ns, request.leap_seconds) if recording.is_absolute else None,
        counts=dict(sorted(writer.counts.items())),
        left_out=left_out,
        findings=findings.all,
        uses=uses,
        wall_s=time.perf_counter() - begin,
    )


class _Checked:
    """One stream with an inspection for each of its series."""

    def __init__(self, stream: Stream, findings: Findings) -> None:
        self._findings = findings
        self._inspections: dict[Series, tuple[Inspection, list[InertialUnits | MotionUnits]]] = {}
        self._portions = self._sound(stream)

    def next(self) -> Portion | None:
        """The next portion with something sound in it."""
        return next(self._portions, None)

    @property
    def left_out(self) -> int:
        """Rows that were not sound."""
        return sum(one.taken - one.kept for one, _ in self._inspections.values())

    def _sound(self, stream: Stream) -> Iterator[Portion]:
        for portion in stream:
            if not isinstance(portion, Rows):
                yield portion
                continue
            if not len(portion):
                continue
            if portion.series not in self._inspections:
                inspection = Inspection(portion.series, self._findings)
                self._inspections[portion.series] = inspection, _unit_checks(portion.series, self._findings)
            inspection, checks = self._inspections[portion.series]
            sound = inspection.take(portion)
            for check in checks:
                check.take(sound)
            if len(sound):
                yield sound
        for inspection, checks in self._inspections.values():
            rest = inspection.finish()
            for check in checks:
                if rest is not None:
                    check.take(rest)
                check.finish()
            if rest is not None and len(rest):
                yield rest


def _unit_checks(series: Series, findings: Findings) -> list[InertialUnits | MotionUnits]:
    columns = set(series.table.columns)
    if columns >= {*RATES, *FORCES}:
        return [InertialUnits(series, findings)]
    if columns >= {*PLACE, *VELOCITY}:
        return [MotionUnits(series, findings)]
    return []


def _write(writer: ImportWriter, portion: Portion, accuracy: list[float] | None) -> None:
    if isinstance(portion, Rows):
        if accuracy is not None and portion.series.topic == "/gnss":
            claimed = portion.series.columns(*ACCURACIES)
            told = portion.values[:, claimed]
            portion.values[:, claimed] = np.where(np.isnan(told), accuracy, told)
        writer.rows(portion)
    else:
        writer.raw(portion)


def _accuracy(text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 or not all(0.0 < value < 1e6 for value in values):
        raise UserError(f"--accuracy {text}: must be three positive numbers, e.g. --accuracy 1.0,2.2,0.15")
    return values


def _check_options(request: ImportRequest) -> None:
    for name, kinds in OPTIONS.items():
        if getattr(request, name) is not None and request.kind not in kinds:
            option = {"mapping": "map", "geoid_separation_m": "geoid-separation"}.get(name, name)
            raise UserError(
                f"--{option.replace('_', '-')} means nothing to import {request.kind}, only to"
                f" {', '.join(kinds)}; leave it away"
            )


def _check_paths(request: ImportRequest) -> None:
    for path in (*(file.path for file in request.files), request.mapping, request.dbc):
        if path is None:
            continue
        try:
            with path.open("rb") as file:
                file.read(1)
        except OSError as error:
            raise UserError(f"{path}: cannot be read: {error.strerror}") from None
    if request.target.exists():
        raise UserError(f"-o {request.target}: exists already; name a new file, e.g. -o drive.mcap")
    if not request.target.parent.is_dir():
        raise UserError(f"-o {request.target}: there is no folder {request.target.parent}")


def _meter(request: ImportRequest) -> Callable[[int], None]:
    whole = sum(file.path.stat().st_size for file in request.files)
    done = 0

    def meter(size: int) -> None:
        nonlocal done
        done += size
        if request.progress is not None:
            request.progress(min(done, whole), whole)

    return meter


def _manifest(request: ImportRequest, recording: Recording, origin_ns: int) -> dict[str, Any]:
    clock: dict[str, Any] = {"base": "gps" if recording.is_absolute else "recording", "origin_ns": origin_ns}
    if recording.is_absolute:
        leaps = request.leap_seconds
        if leaps is None:
            leaps = leap_seconds_at(unix_from_gps(origin_ns))
        clock |= {"origin_utc": utc_text(origin_ns, leaps), "leap_seconds": leaps}
    return {
        "format": IMPORT_FORMAT,
        "kind": request.kind,
        "files": [{"name": file.name, "bytes": file.path.stat().st_size} for file in request.files],
        "units": list(request.units),
        "stated_accuracy": request.accuracy,
        "clock": clock,
        "versions": versions(),
        **recording.facts,
    }


def _uses(counts: dict[str, int], is_apart: bool) -> list[str]:
    inertial = any(topic.startswith("/imu/") for topic in counts)
    uses = ["capture info, check, cut, export"]
    if is_apart:
        uses.append("no physical replay: its streams have no time in common")
    elif inertial and "/gnss" in counts:
        uses.append("physical replay: navtwin replay CAPTURE --board car_mems --mode physical")
    elif inertial:
        uses.append("no physical replay: there is no receiver in it")
    elif "/gnss" in counts:
        uses.append("no physical replay: there are no inertial samples in it")
    if any(topic.startswith("/uart/") for topic in counts):
        uses.append("the receiver's own bytes are kept: capture export --format nmea")
    return uses
