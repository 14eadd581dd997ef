"""Trajectories as CSV with a header. Columns are known by their names; those of no meaning here are left out.

| quantity | names | unit |
| --- | --- | --- |
| time | t_s, time, time_s, timestamp, t_ns | s (or ns); or ISO 8601 |
| place | latitude_deg, lat, latitude; longitude_deg, lon, longitude; height_m, alt, altitude, height | °, m |
| velocity | v_north_mps, VN, vn; v_east_mps …; v_down_mps … | m/s |
| attitude | yaw_deg, heading, yaw; pitch_deg, pitch; roll_deg, roll | ° |

With `true_` in front they are known too, as in what `navtwin simulate` writes; `_rad` at the end means rad.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import TextIO

import numpy as np

from host.record.errors import UserError
from host.simulate.tracks.clock import gps_ns
from host.simulate.tracks.track import Floats, Track, checked

NAMES: dict[str, tuple[str, ...]] = {
    "time": ("t_s", "time", "time_s", "timestamp"),
    "latitude": ("latitude_deg", "lat", "latitude", "lat_deg"),
    "longitude": ("longitude_deg", "lon", "longitude", "lon_deg", "lng"),
    "height": ("height_m", "alt", "altitude", "height", "altitude_m", "h_m"),
    "north": ("v_north_mps", "vn", "v_n"),
    "east": ("v_east_mps", "ve", "v_e"),
    "down": ("v_down_mps", "vd", "v_d"),
    "yaw": ("yaw_deg", "heading", "yaw", "heading_deg"),
    "pitch": ("pitch_deg", "pitch"),
    "roll": ("roll_deg", "roll"),
}
VELOCITY, ATTITUDE = ("north", "east", "down"), ("yaw", "pitch", "roll")
NEEDED = ("time", "latitude", "longitude", "height")
ANGLES = ("latitude", "longitude", "yaw", "pitch", "roll")
OTHER_UNITS = (
    "ft",
    "feet",
    "km",
    "mi",
    "kmh",
    "kph",
    "knots",
    "kn",
    "mph",
    "ms",
    "us",
    "grad",
    "mrad",
    "dm",
    "cm",
)
EXAMPLE = "for example t_s,latitude_deg,longitude_deg,height_m"


def read_csv(path: Path) -> tuple[Track, list[int]]:
    """The track, and the line of each point. Raises UserError."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        table_rows = _rows(path, file)
        header = [name.strip() for name in next(table_rows, (1, []))[1]]
        columns = _columns(path, header)
        rows: list[list[float]] = []
        lines: list[int] = []
        clock: Clock | None = None
        for line, row in table_rows:
            if len(row) < len(header) or any(cell.strip() for cell in row[len(header) :]):
                raise UserError(f"{path}: line {line}: {len(row)} values, the header has {len(header)}")
            if clock is None:
                place, unit_s = columns["time"]
                clock = Clock(row[place].strip(), unit_s)
            rows.append([_value(path, line, name, row, columns, clock) for name in columns])
            lines.append(line)
    table = np.array(rows, dtype=np.float64).reshape(-1, len(columns))
    named = {name: table[:, k] for k, name in enumerate(columns)}
    begin = None if clock is None else clock.start
    return checked(_track(named, begin), str(path), lambda k: f"line {lines[k]}"), lines


class Clock:
    """Times since that of the first row, in which no digit is lost when they count from 1970."""

    def __init__(self, first: str, unit_s: float) -> None:
        self.start = _moment(first) if unit_s == 1.0 else None
        """When the first row tells its date."""
        self._unit_s = unit_s
        self._first = first

    def seconds(self, text: str) -> float:
        """ValueError for what is no time like the first."""
        if self.start is not None:
            moment = _moment(text)
            if moment is None:
                raise ValueError("is not ISO 8601, as that of the first line is")
            return (moment - self.start).total_seconds()
        try:
            return float(Decimal(text) - Decimal(self._first)) * self._unit_s
        except InvalidOperation:
            pass
        try:
            return float(text)  # not finite
        except ValueError:
            raise ValueError("is not a number; for example 12.5") from None


def _rows(path: Path, file: TextIO) -> Iterator[tuple[int, list[str]]]:
    """Rows that are not empty, with their lines. Raises UserError."""
    reader = csv.reader(file)
    try:
        for row in reader:
            if reader.line_num == 1 or any(cell.strip() for cell in row):
                yield reader.line_num, row
    except csv.Error as error:
        raise UserError(f"{path}: line {reader.line_num + 1}: {error}; is it a table? {EXAMPLE}") from None


def _columns(path: Path, header: list[str]) -> dict[str, tuple[int, float]]:
    """Place and factor to SI of each quantity that the header names."""
    known = [name.lower().removeprefix("true_") for name in header]
    found: dict[str, tuple[int, float]] = {}
    for quantity, names in NAMES.items():
        for name in names:
            angle = math.pi / 180.0 if quantity in ANGLES else 1.0
            for wanted, factor in ((name, angle), (f"{name.removesuffix('_deg')}_rad", 1.0)):
                if wanted in known and quantity not in found:
                    found[quantity] = (known.index(wanted), factor)
    if "time" not in found and "t_ns" in known:
        found["time"] = (known.index("t_ns"), 1e-9)
    _refuse_doubtful(path, header, known)
    missing = [name for name in NEEDED if name not in found]
    if missing:
        told = ", ".join(header[:8]) or "nothing"
        raise UserError(f"{path}: line 1: no column of {missing[0]} in the header ({told}); {EXAMPLE}")
    return found


def _refuse_doubtful(path: Path, header: list[str], known: list[str]) -> None:
    """UserError for a quantity in a unit that is not known, and for a column that is there twice."""
    understood = {name for names in NAMES.values() for name in names}
    understood |= {f"{name.removesuffix('_deg')}_rad" for name in understood} | {"t_ns"}
    stems = {name.rsplit("_", 1)[0] if "_" in name else name for name in understood}
    for place, name in enumerate(known):
        stem, _, unit = name.rpartition("_")
        if name not in understood and stem in stems and unit in OTHER_UNITS:
            raise UserError(
                f"{path}: line 1: column {header[place]}: {unit} is no unit known here; angles are in deg or"
                f" rad, lengths in m, speeds in mps, times in s or ns; {EXAMPLE}"
            )
        if name in understood and name in known[:place]:
            raise UserError(f"{path}: line 1: column {header[place]} is there twice; keep one")


def _value(
    path: Path,
    line: int,
    name: str,
    row: list[str],
    columns: Mapping[str, tuple[int, float]],
    clock: Clock,
) -> float:
    place, factor = columns[name]
    text = row[place].strip()
    if name == "time":
        try:
            return clock.seconds(text)
        except ValueError as error:
            raise UserError(f"{path}: line {line}: time {text!r} {error}") from None
    try:
        return float(text) * factor
    except ValueError:
        raise UserError(f"{path}: line {line}: {name} {text!r} is not a number; for example 12.5") from None


def _moment(text: str) -> datetime | None:
    """An ISO time with date; None when it is something else."""
    if "-" not in text[1:] or ":" not in text:
        return None
    try:
        moment = datetime.fromisoformat(text.strip())
    except ValueError:
        return None
    return moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)


def _track(named: Mapping[str, Floats], start: datetime | None) -> Track:
    velocity, attitude = _together(named, VELOCITY), _together(named, ATTITUDE)
    given = [*((VELOCITY,) if velocity is None else ()), *((ATTITUDE,) if attitude is None else ())]
    unused = tuple(name for names in given for name in names if name in named)
    t = named["time"]
    place = (named["latitude"], named["longitude"], named["height"])
    begin = None if start is None else gps_ns(start)
    return Track(t, *place, velocity, attitude, begin, unused=unused)


def _together(named: Mapping[str, Floats], names: tuple[str, str, str]) -> Floats | None:
    """Three columns that only mean something together; None where one lacks."""
    return np.column_stack([named[name] for name in names]) if set(names) <= set(named) else None
