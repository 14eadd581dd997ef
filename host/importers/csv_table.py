"""Tables of comma-separated (or otherwise separated) values, by a mapping file."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from boards.hints import did_you_mean
from host.importers import topics
from host.importers.csv_mapping import (
    Column,
    Gnss,
    Height,
    Imu,
    Mapping,
    Position,
    Section,
    Time,
    Truth,
    Velocity,
    load_mapping,
)
from host.importers.number_lines import Cell, ns_of_seconds, number_blocks
from host.importers.request import InputFile, Recording, Task
from host.importers.series import Floats, Integers, Rows, Series, Stream, in_line
from host.importers.time_base import WEEK_NS, gps_from_unix
from host.importers.units import DEGREES, Unit
from host.record.errors import UserError

SCALES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "iso8601": 1.0}
SHOWN, MOST_NAMES = 24, 60
DELIMITERS = ",;\t|"
UNIX_EPOCH = datetime.fromisoformat("1970-01-01T00:00:00+00:00")


def read_csv(task: Task) -> Recording:
    """All sections of the mapping, each from its file."""
    mapping = load_mapping(task.request.mapping)
    assert task.request.mapping is not None
    bases = {(section.time or mapping.time).base for section in mapping.sections.values()}  # type: ignore[union-attr]
    if "recording" in bases and len(bases) > 1:
        named = " and ".join(sorted(map(repr, bases)))
        raise UserError(
            f"{task.request.mapping}: base = {named}: clocks of a recording's"
            " own and of GPS or UTC cannot be put together; give all sections one of gps, unix, week"
        )
    files = {name: _file_of(task, name, section) for name, section in mapping.sections.items()}
    for file in task.request.files:
        if file not in files.values():
            raise UserError(
                f"import csv: {file.name} is used by no section of {task.request.mapping};"
                f" name it there, file = {file.name!r}, or leave it away"
            )
    streams: list[Stream] = [
        _stream(task, mapping, name, section, files[name]) for name, section in mapping.sections.items()
    ]
    text = task.request.mapping.read_text(encoding="utf-8-sig")
    return Recording(streams, is_absolute="recording" not in bases, facts={"mapping": text})


def _file_of(task: Task, name: str, section: Section) -> InputFile:
    files = task.request.files
    for file in files:
        if file.role == name or (section.file is not None and file.name == section.file):
            return file
    free = [file for file in files if file.role is None]
    if section.file is None and len(files) == 1 and free:
        return free[0]
    wanted = (
        f"file = {section.file!r} in [{name}] is none of"
        if section.file
        else f"[{name}] may come from any of"
    )
    known = ", ".join(file.name for file in files)
    raise UserError(f"import csv: {wanted} {known}; say which: navtwin import csv {name}={files[0].path} …")


@dataclass(frozen=True, slots=True)
class _Layout:
    """How a file is cut into cells."""

    path: Path
    delimiter: str | None
    names: list[str]
    skip: int

    def place(self, column: Column, key: str) -> int:
        """Of a column, from 0."""
        if isinstance(column, int):
            return column - 1
        if column in self.names:
            return self.names.index(column)
        hint = did_you_mean(column, [ascii(name[:SHOWN])[1:-1] for name in self.names[:MOST_NAMES] if name])
        raise UserError(
            f"{self.path}: {key} names the column {column!r}, which the header does not have; {hint}"
        )


def _layout(path: Path, mapping: Mapping) -> _Layout:
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for number in range(mapping.skip_lines):
            if not file.readline(1 << 14):
                raise UserError(f"{path}: skip_lines = {mapping.skip_lines}, but it has only {number} lines")
        line = file.readline(1 << 14)
        if not line:
            raise UserError(f"{path}: it is empty" + (" behind skip_lines" if mapping.skip_lines else ""))
        skip = mapping.skip_lines + mapping.header
        while mapping.header and line and (not line.strip()):
            line, skip = file.readline(1 << 14), skip + 1
    head = line.strip().lstrip("#").strip()
    delimiter = mapping.delimiter
    if delimiter is None:
        counts = {one: head.count(one) for one in DELIMITERS}
        best = max(counts, key=lambda one: counts[one])
        delimiter = best if counts[best] else None
    if delimiter == " ":
        delimiter = None
    names: list[str] = []
    if mapping.header:
        cells = head.split() if delimiter is None else next(csv.reader([head], delimiter=delimiter), [])
        names = [cell.strip() for cell in cells]
    return _Layout(path, delimiter, names, skip)


class _Columns:
    """Columns that are asked for, and where their values come to lie."""

    def __init__(self, layout: _Layout) -> None:
        self._layout = layout
        self.wanted: list[int] = []
        self.cells: list[Cell | None] = []

    def add(self, column: Column | None, key: str, cell: Cell | None = None) -> int | None:
        """Where its values will be; None when it is not asked for."""
        if column is None:
            return None
        self.wanted.append(self._layout.place(column, key))
        self.cells.append(cell)
        return len(self.wanted) - 1

    def several(self, columns: Sequence[Column], key: str) -> list[int]:
        """Where their values will be."""
        return [place for column in columns if (place := self.add(column, key)) is not None]


class _Clock:
    """Times of rows."""

    def __init__(self, time: Time, columns: _Columns, leap_seconds: int | None) -> None:
        self._time = time
        self._leap_seconds = leap_seconds
        cell = _iso_seconds if time.unit == "iso8601" else None
        place = columns.add(time.column, "time.column", cell)
        assert place is not None
        self.place = place
        self._week = columns.add(time.week_column, "time.week_column")

    @property
    def places(self) -> list[int]:
        """Where times stand."""
        return [self.place] if self._week is None else [self.place, self._week]

    @property
    def scale(self) -> float:
        """Of the time column, into s."""
        return SCALES[self._time.unit]

    def times(self, values: Floats) -> Integers:
        """ns: of GPS time, or of the recording's own clock."""
        own = ns_of_seconds(values[:, self.place])
        if self._time.base == "unix" or self._time.unit == "iso8601":
            return gps_from_unix(own, self._leap_seconds)
        if self._time.base == "week":
            week = self._time.week if self._week is None else values[:, self._week].astype(np.int64)
            return own + np.asarray(week, dtype=np.int64) * WEEK_NS
        return own


def _iso_seconds(text: str) -> float:
    moment = datetime.fromisoformat(text.strip().strip('"'))
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UNIX_EPOCH.tzinfo)
    return (moment - UNIX_EPOCH) / timedelta(seconds=1)


def _stream(task: Task, mapping: Mapping, name: str, section: Section, file: InputFile) -> Iterator[Rows]:
    layout = _layout(file.path, mapping)
    columns = _Columns(layout)
    time = section.time or mapping.time
    assert time is not None
    clock = _Clock(time, columns, task.request.leap_seconds)
    if isinstance(section, Imu):
        made = _imu(task, section, file, columns)
    elif isinstance(section, Gnss):
        made = _gnss(task, section, file, columns)
    else:
        assert isinstance(section, Truth)
        made = _truth(task, section, file, columns)

    def rows() -> Iterator[Rows]:
        scale = {clock.place: clock.scale}
        for values, lines in number_blocks(
            file.path,
            columns.wanted,
            layout.delimiter,
            task.findings,
            task.meter,
            skip=layout.skip,
            cells=columns.cells if any(columns.cells) else (),
            times=clock.places,
            scales=scale,
        ):
            times = clock.times(values)
            for one in made:
                yield Rows(one.series, times, one.table(values), lines)

    return rows()


class _Made:
    """One series out of columns: each of the table's columns is a sum of columns with factors."""

    def __init__(self, series: Series) -> None:
        self.series = series
        self._parts: list[tuple[int, int, float]] = []
        self._constants: list[tuple[int, float]] = []
        self._polar: tuple[int, int, float, float] | None = None

    def put(self, name: str, place: int | None, factor: float = 1.0) -> None:
        """A column of the table."""
        if place is not None:
            self._parts.append((self.series.columns(name)[0], place, factor))

    def constant(self, name: str, value: float) -> None:
        """Added to what is measured of a column of the table; all of it when nothing is."""
        self._constants.append((self.series.columns(name)[0], value))

    def polar(self, speed: int, course: int, factor: float, to_degrees: float) -> None:
        """Velocity from speed and course."""
        self._polar = speed, course, factor, to_degrees

    def table(self, values: Floats) -> Floats:
        """(n, columns − 1)."""
        out = np.full((len(values), len(self.series.table.columns) - 1), np.nan)
        for column, place, factor in self._parts:
            out[:, column] = values[:, place] * factor
        measured = {column for column, _, _ in self._parts}
        for column, constant in self._constants:
            out[:, column] = out[:, column] + constant if column in measured else constant
        if self._polar is not None:
            speed, course, factor, to_degrees = self._polar
            angle = values[:, course] * to_degrees / DEGREES
            north, east = self.series.columns("v_north_mps", "v_east_mps")
            out[:, north] = values[:, speed] * factor * np.cos(angle)
            out[:, east] = values[:, speed] * factor * np.sin(angle)
        return out


def _imu(task: Task, section: Imu, file: InputFile, columns: _Columns) -> list[_Made]:
    units = {
        "gyro": task.units.of("gyro", section.gyro.unit),
        "accel": task.units.of("accel", section.accel.unit),
    }
    made = _Made(topics.samples(section.name, file.name, in_line, units))
    gyro = columns.several(section.gyro.columns, "imu.gyro.columns")
    accel = columns.several(section.accel.columns, "imu.accel.columns")
    _turned(made, topics.RATES, gyro, section.axes, units["gyro"].factor)
    _turned(made, topics.FORCES, accel, section.axes, units["accel"].factor)
    made.put("temperature_degc", columns.add(section.temperature, "imu.temperature"))
    if section.mag is None:
        return [made]
    unit = task.units.of("mag", section.mag.unit)
    field = _Made(topics.magnetic(section.name, file.name, in_line, {"mag": unit}))
    places = columns.several(section.mag.columns, "imu.mag.columns")
    _turned(field, topics.FIELD.columns[1:], places, section.axes, unit.factor)
    return [made, field]


def _turned(
    made: _Made, names: Sequence[str], places: Sequence[int], axes: Sequence[str], factor: float
) -> None:
    for name, axis in zip(names, axes, strict=True):
        made.put(name, places["xyz".index(axis[-1])], -factor if axis[0] == "-" else factor)


def _motion(
    made: _Made,
    position: Position,
    height: Height,
    velocity: Velocity | None,
    columns: _Columns,
    units: dict[str, Unit],
) -> None:
    latitude, longitude = columns.several(position.columns, "position.columns")
    made.put("latitude_deg", latitude, units["position"].factor)
    made.put("longitude_deg", longitude, units["position"].factor)
    made.put("height_m", columns.add(height.column, "height.column"), units["height"].factor)
    if height.above == "sea" and height.geoid_separation_m is not None:
        made.constant("height_m", height.geoid_separation_m)
    if velocity is None:
        return
    factor = units["velocity"].factor
    if velocity.columns is not None:
        one, other, third = columns.several(velocity.columns, "velocity.columns")
        north, east, down, sign = (
            (one, other, third, 1.0) if velocity.frame == "ned" else (other, one, third, -1.0)
        )
        made.put("v_north_mps", north, factor)
        made.put("v_east_mps", east, factor)
        made.put("v_down_mps", down, sign * factor)
        return
    speed, course = (
        columns.add(velocity.speed, "velocity.speed"),
        columns.add(velocity.course, "velocity.course"),
    )
    assert speed is not None
    assert course is not None
    made.polar(speed, course, factor, 1.0 if velocity.course_unit == "deg" else DEGREES)


def _motion_units(task: Task, section: Gnss | Truth) -> dict[str, Unit]:
    units = {
        "position": task.units.of("position", section.position.unit),
        "height": task.units.of("height", section.height.unit),
    }
    if section.velocity is not None:
        units["velocity"] = task.units.of("velocity", section.velocity.unit)
    return units


def _gnss(task: Task, section: Gnss, file: InputFile, columns: _Columns) -> list[_Made]:
    units = _motion_units(task, section)
    made = _Made(topics.epochs(file.name, in_line, units))
    _motion(made, section.position, section.height, section.velocity, columns, units)
    if section.fix is None:
        made.constant("fix", 1.0)
    else:
        made.put("fix", columns.add(section.fix, "gnss.fix"))
    others = (("h_acc_m", section.h_acc), ("v_acc_m", section.v_acc), ("s_acc_mps", section.s_acc))
    for name, column in (*others, ("satellites", section.satellites), ("hdop", section.hdop)):
        made.put(name, columns.add(column, f"gnss.{name}"))
    if section.height.geoid_separation_m is not None:
        made.constant("geoid_separation_m", section.height.geoid_separation_m)
    return [made]


def _truth(task: Task, section: Truth, file: InputFile, columns: _Columns) -> list[_Made]:
    units = _motion_units(task, section)
    if section.attitude is not None:
        units["attitude"] = task.units.of("attitude", section.attitude.unit)
    made = _Made(topics.truth(file.name, in_line, units))
    _motion(made, section.position, section.height, section.velocity, columns, units)
    if section.attitude is not None:
        places = columns.several(section.attitude.columns, "truth.attitude.columns")
        for name, place in zip(("yaw_deg", "pitch_deg", "roll_deg"), places, strict=True):
            made.put(name, place, units["attitude"].factor)
    return [made]
