"""GPX tracks, and KML as gx:Track (with times) or LineString (with the speed that the caller names).

Heights of both are taken as they stand; GPX means mean sea level, and the geoid is not known here.
"""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from host.record.errors import UserError
from host.sim.earth import radians_per_metre
from host.simulate.tracks.clock import gps_ns
from host.simulate.tracks.track import Floats, Track, checked

Point = tuple[float, float, float]


def read_gpx(path: Path) -> tuple[Track, list[int]]:
    """All track points of all segments. Raises UserError."""
    places: list[Point] = []
    moments: list[datetime] = []
    for number, point in enumerate(_all(_parsed(path), "trkpt"), start=1):
        where = f"{path}: point {number}"
        height = _text(point, "ele")
        places.append(
            (
                _number(where, "lat", point.get("lat")),
                _number(where, "lon", point.get("lon")),
                0.0 if height is None else _number(where, "ele", height),
            )
        )
        moments.append(_moment(where, _text(point, "time")))
    if not places:
        raise UserError(f"{path}: holds no track points (trkpt); routes and waypoints have no times")
    return _timed(path, places, moments)


def read_kml(path: Path, speed_mps: float | None) -> tuple[Track, list[int]]:
    """The first gx:Track; else the first LineString at a constant speed. Raises UserError."""
    root = _parsed(path)
    for track in _all(root, "Track"):
        whens = [_moment(f"{path}: when {k}", one.text) for k, one in enumerate(_all(track, "when"), start=1)]
        coords = [
            _coordinates(f"{path}: coord {k}", (one.text or "").split())
            for k, one in enumerate(_all(track, "coord"), start=1)
        ]
        if len(whens) != len(coords):
            raise UserError(
                f"{path}: gx:Track has {len(whens)} times (when) for {len(coords)} places (gx:coord)"
            )
        return _timed(path, coords, whens)
    for line in _all(root, "LineString"):
        texts = (_text(line, "coordinates") or "").split()
        coords = [
            _coordinates(f"{path}: coordinates {k}", one.split(",")) for k, one in enumerate(texts, start=1)
        ]
        if speed_mps is None:
            raise UserError(
                f"{path}: a LineString has no times; export a track (gx:Track), or give the speed: --speed 10"
            )
        return _driven(path, coords, speed_mps)
    raise UserError(f"{path}: holds neither a gx:Track nor a LineString")


def _timed(path: Path, places: list[Point], moments: list[datetime]) -> tuple[Track, list[int]]:
    numbers = list(range(1, len(places) + 1))
    t = np.array([(moment - moments[0]).total_seconds() for moment in moments])
    start = gps_ns(moments[0]) if moments else None
    track = Track(t, *_columns(places), start_gps_ns=start, noisy=True)
    return checked(track, str(path), lambda k: f"point {numbers[k]}"), numbers


def _driven(path: Path, places: list[Point], speed_mps: float) -> tuple[Track, list[int]]:
    latitude, longitude, height = _columns(places)
    numbers = list(range(1, len(places) + 1))
    steps = np.zeros(0)
    if len(places) > 1:
        per_north, per_east = radians_per_metre(float(latitude[0]), float(height[0]))
        north, east = np.diff(latitude) / per_north, np.diff(np.unwrap(longitude)) / per_east
        steps = np.sqrt(north**2 + east**2 + np.diff(height) ** 2)
    t = np.concatenate(([0.0], np.cumsum(steps))) / speed_mps
    track = Track(t[: len(places)], latitude, longitude, height, noisy=True)
    return checked(track, str(path), lambda k: f"point {numbers[k]}"), numbers


def _columns(places: list[Point]) -> tuple[Floats, Floats, Floats]:
    table = np.array(places, dtype=np.float64).reshape(-1, 3)
    return np.radians(table[:, 0]), np.radians(table[:, 1]), table[:, 2].copy()


def _parsed(path: Path) -> ElementTree.Element:
    try:
        return ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # the last two: of its encoding
        raise UserError(f"{path}: is not valid XML: {error}") from None


def _all(root: ElementTree.Element, name: str) -> list[ElementTree.Element]:
    """Elements of this name in any namespace, in their order."""
    return [one for one in root.iter() if one.tag.rpartition("}")[2] == name]


def _text(parent: ElementTree.Element, name: str) -> str | None:
    found = _all(parent, name)
    return found[0].text if found else None


def _coordinates(where: str, parts: list[str]) -> Point:
    """KML's order: longitude, latitude, height."""
    if len(parts) not in (2, 3):
        raise UserError(
            f"{where}: {' '.join(parts)!r} is not longitude, latitude, height; e.g. 8.31 47.05 440"
        )
    longitude, latitude = _number(where, "longitude", parts[0]), _number(where, "latitude", parts[1])
    return latitude, longitude, _number(where, "height", parts[2]) if len(parts) == 3 else 0.0


def _number(where: str, name: str, text: str | None) -> float:
    try:
        return float(text or "")
    except ValueError:
        raise UserError(f"{where}: {name} {text!r} is not a number; for example 47.05") from None


def _moment(where: str, text: str | None) -> datetime:
    try:
        moment = datetime.fromisoformat((text or "").strip())
    except ValueError:
        raise UserError(f"{where}: time {text!r} is not ISO 8601; for example 2024-05-14T08:00:00Z") from None
    return moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
