"""NMEA logs: positions of GGA with a fix, the date of RMC or ZDA; ellipsoidal heights, by the separation."""

from __future__ import annotations

import functools
import operator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from host.record.errors import UserError
from host.simulate.tracks.clock import gps_ns
from host.simulate.tracks.track import Track, checked

HALF_DAY_S = 43200.0
NORTH, EAST = {"N": 1.0, "S": -1.0}, {"E": 1.0, "W": -1.0}


def read_nmea(path: Path) -> tuple[Track, list[int]]:
    """The track, and the line of each point; what has a wrong checksum is left out. Raises UserError."""
    rows: list[tuple[float, float, float, float]] = []
    lines: list[int] = []
    date: datetime | None = None
    bad = 0
    day = 0.0
    for number, text in enumerate(path.read_text(encoding="ascii", errors="replace").splitlines(), start=1):
        fields = _fields(text)
        if fields is None:
            bad += "$" in text
            continue
        kind = fields[0][2:]
        if kind == "RMC" and len(fields) > 9 and date is None:
            date = _date(fields[9][:2], fields[9][2:4], f"20{fields[9][4:6]}")
        elif kind == "ZDA" and len(fields) > 4 and date is None:
            date = _date(*fields[2:5])
        elif kind == "GGA" and len(fields) > 11 and fields[6] not in ("", "0"):
            row = _epoch(path, number, fields)
            if rows and row[0] + day < rows[-1][0] - HALF_DAY_S:
                day += 86400.0
            rows.append((row[0] + day, *row[1:]))
            lines.append(number)
    if not rows:
        raise UserError(f"{path}: no GGA sentence with a fix ({bad} lines with a wrong checksum)")
    table = np.array(rows)
    start = None if date is None else gps_ns(date + timedelta(seconds=rows[0][0]))
    place = (np.radians(table[:, 1]), np.radians(table[:, 2]), table[:, 3].copy())
    track = Track(table[:, 0] - table[0, 0], *place, start_gps_ns=start, noisy=True)
    return checked(track, str(path), lambda k: f"line {lines[k]}"), lines


def _fields(line: str) -> list[str] | None:
    """Fields of a sentence whose checksum is right; None for anything else."""
    begin = line.find("$")
    body, star, checksum = line[begin + 1 :].partition("*")
    if begin < 0 or not star:
        return None
    sum_ = functools.reduce(operator.xor, body.encode(errors="replace"), 0)
    return body.split(",") if checksum.strip().upper() == f"{sum_:02X}" else None


def _date(day: str, month: str, year: str) -> datetime | None:
    try:
        return datetime(int(year), int(month), int(day), tzinfo=UTC)
    except ValueError:
        return None


def _epoch(path: Path, line: int, fields: list[str]) -> tuple[float, float, float, float]:
    """Second of the day, latitude °, longitude °, ellipsoidal height m."""
    try:
        clock = fields[1]
        hour, minute = int(clock[:2]), int(clock[2:4])
        if not (0 <= hour < 24 and 0 <= minute < 60):
            raise ValueError
        second = hour * 3600 + minute * 60 + _sixty(clock[4:])
        latitude = (int(fields[2][:2]) + _sixty(fields[2][2:]) / 60.0) * NORTH[fields[3]]
        longitude = (int(fields[4][:3]) + _sixty(fields[4][3:]) / 60.0) * EAST[fields[5]]
        return second, latitude, longitude, float(fields[9]) + float(fields[11] or 0.0)
    except (ValueError, KeyError):
        raise UserError(f"{path}: line {line}: GGA that cannot be read: {','.join(fields)}") from None


def _sixty(text: str) -> float:
    """Minutes or seconds. Raises ValueError for more of them than there can be."""
    value = float(text)
    if not 0.0 <= value < 61.0:  # a leap second
        raise ValueError
    return value
