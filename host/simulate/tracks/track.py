"""A trajectory as a file tells it: points in the order of time, some with velocity and attitude."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.record.errors import UserError
from host.sim.earth import radians_per_metre

Floats = NDArray[np.float64]

LEAST_POINTS = 4
FASTEST_MPS = 3000.0
LONGEST_S = 1e7
POLE_DEG = 89.0
LOWEST_M, HIGHEST_M = -1000.0, 100_000.0
FARTHEST_DEG = 360.0
LARGEST_ANGLE_DEG = 36_000.0
"""Of yaw and roll, which may go on counting turn after turn."""
APART_M, APART_SHARE = 10.0, 0.5
"""How far velocities may lead from the next point: lengths, and a share of the way at the larger speed."""
LATEST_GPS_NS = 4_000_000_000 * 10**9
"""In 2106: a date beyond is none."""


@dataclass(frozen=True)
class Track:
    """Angles in rad, heights above the ellipsoid, velocities north, east, down."""

    t_s: Floats
    """Rising, from 0."""
    latitude: Floats
    longitude: Floats
    height: Floats
    velocity: Floats | None = None
    """(n, 3)."""
    attitude: Floats | None = None
    """(n, 3): yaw, pitch, roll."""
    start_gps_ns: int | None = None
    """GPS time of the first point; None: the file does not tell."""
    noisy: bool = False
    """Whether its points come from a receiver and are to be smoothed unless asked otherwise."""
    unused: tuple[str, ...] = ()
    """Quantities of which the file tells only a part, too little to be used."""

    def __len__(self) -> int:
        return len(self.t_s)


def checked(track: Track, source: str, place: Callable[[int], str]) -> Track:
    """The track, when a vehicle can have driven it; `place` names a point: `line 12`. Raises UserError."""
    if len(track) < LEAST_POINTS:
        raise UserError(f"{source}: holds {len(track)} points; a trajectory needs {LEAST_POINTS} at least")
    _check_numbers(track, source, place)
    _check_times(track, source, place)
    degrees = np.degrees(track.latitude)
    _none(
        np.abs(degrees) > POLE_DEG,
        source,
        place,
        lambda k: f"latitude {degrees[k]:g}° (at most ±{POLE_DEG:g}°)",
    )
    east = np.degrees(track.longitude)
    _none(np.abs(east) > FARTHEST_DEG, source, place, lambda k: f"longitude {east[k]:g}° (at most ±360°)")
    away = (track.height < LOWEST_M) | (track.height > HIGHEST_M)
    _none(away, source, place, lambda k: f"height {track.height[k]:g} m ({LOWEST_M:g} … {HIGHEST_M:g} m)")
    if track.attitude is not None:
        pitch = np.degrees(track.attitude[:, 1])
        _none(np.abs(pitch) > 90.0, source, place, lambda k: f"pitch {pitch[k]:g}° (at most ±90°)")
        _check_turns(track.attitude, source, place)
    speed = np.concatenate(([0.0], np.linalg.norm(_steps(track), axis=1) / np.diff(track.t_s)))
    _none(
        speed > FASTEST_MPS,
        source,
        place,
        lambda k: f"{speed[k]:,.0f} m/s from the point before (at most {FASTEST_MPS:,.0f})",
    )
    _check_velocity(track, source, place)
    return track


def _check_turns(attitude: Floats, source: str, place: Callable[[int], str]) -> None:
    """Yaw and roll are angles."""
    for name, column in (("yaw", 0), ("roll", 2)):
        angle = np.degrees(attitude[:, column])

        def told(k: int, name: str = name, angle: Floats = angle) -> str:
            return f"{name} {angle[k]:g}° (at most ±{LARGEST_ANGLE_DEG:,.0f}°)"

        _none(np.abs(angle) > LARGEST_ANGLE_DEG, source, place, told)


def _check_velocity(track: Track, source: str, place: Callable[[int], str]) -> None:
    """It is that of the points: what it leads to is not far from the next one."""
    if track.velocity is None:
        return
    speeds = np.linalg.norm(track.velocity, axis=1)
    _none(
        speeds > FASTEST_MPS,
        source,
        place,
        lambda k: f"velocity {speeds[k]:,.0f} m/s (at most {FASTEST_MPS:,.0f})",
    )
    lengths = np.diff(track.t_s)
    led = 0.5 * (track.velocity[1:] + track.velocity[:-1]) * lengths[:, None]
    off = np.linalg.norm(led - _steps(track), axis=1)
    way = np.maximum(speeds[1:], speeds[:-1]) * lengths
    wrong = np.concatenate(([False], off > APART_M + APART_SHARE * way))

    def told(k: int) -> str:
        return (
            f"the velocities lead {off[k - 1]:,.0f} m beside this point; are they north, east, down in m/s,"
            " and of this trajectory?"
        )

    _none(wrong, source, place, told)


def _check_numbers(track: Track, source: str, place: Callable[[int], str]) -> None:
    named: list[tuple[str, Floats, str]] = [
        ("time", track.t_s, "12.5 s"),
        ("latitude", track.latitude, "47.05°"),
    ]
    named += [("longitude", track.longitude, "8.31°"), ("height", track.height, "440 m")]
    for name, columns in (("velocity", track.velocity), ("attitude", track.attitude)):
        if columns is not None:
            named.append((name, columns.sum(axis=1), "0.5 on each axis"))
    for name, values, example in named:

        def told(k: int, name: str = name, values: Floats = values, example: str = example) -> str:
            return f"the {name} is {values[k]:g}, no finite number; for example {example}"

        _none(~np.isfinite(values), source, place, told)


def _check_times(track: Track, source: str, place: Callable[[int], str]) -> None:
    t = track.t_s
    if track.start_gps_ns is not None and not 0 <= track.start_gps_ns < LATEST_GPS_NS:
        raise UserError(
            f"{source}: {place(0)}: the date lies outside of 1980 … 2106; for example 2024-05-14T08:00:00Z"
        )
    back = np.concatenate(([False], np.diff(t) <= 0.0))

    def told(k: int) -> str:
        if t[k] == t[k - 1]:
            return f"time {t[k]:g} s is that of the point before; keep one of the two"
        return f"time goes back from {t[k - 1]:g} s to {t[k]:g} s; sort the points, or cut the file there"

    _none(back, source, place, told)
    if t[-1] - t[0] > LONGEST_S:
        raise UserError(
            f"{source}: lasts {t[-1] - t[0]:.3g} s, at most {LONGEST_S:g} s; is the time in seconds?"
        )


def check_gaps(track: Track, longest_s: float, source: str, place: Callable[[int], str]) -> None:
    """No two points are further apart in time. Raises UserError."""
    gaps = np.concatenate(([0.0], np.diff(track.t_s)))
    _none(
        gaps > longest_s,
        source,
        place,
        lambda k: (
            f"{gaps[k]:g} s after the point before; cut the file there, or allow it with"
            f" --max-gap {math.ceil(gaps[k])}"
        ),
    )


def _none(
    bad: NDArray[np.bool_], source: str, place: Callable[[int], str], told: Callable[[int], str]
) -> None:
    found: Sequence[int] = np.flatnonzero(bad).tolist()
    if found:
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        raise UserError(f"{source}: {place(found[0])}: {told(found[0])}{more}")


def _steps(track: Track) -> Floats:
    """Ways between neighbours north, east, down, m (n - 1, 3)."""
    pairs = zip(track.latitude.tolist(), track.height.tolist(), strict=True)
    per_north, per_east = np.array([radians_per_metre(*pair) for pair in pairs])[:-1].T
    north, east = np.diff(track.latitude) / per_north, np.diff(np.unwrap(track.longitude)) / per_east
    return np.column_stack((north, east, -np.diff(track.height)))
