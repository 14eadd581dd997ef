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
    away = (track.height < LOWEST_M) | (track.height > HIGHEST_M)
    _none(away, source, place, lambda k: f"height {track.height[k]:g} m ({LOWEST_M:g} … {HIGHEST_M:g} m)")
    if track.attitude is not None:
        pitch = np.degrees(track.attitude[:, 1])
        _none(np.abs(pitch) > 90.0, source, place, lambda k: f"pitch {pitch[k]:g}° (at most ±90°)")
    speed = np.concatenate(([0.0], _steps(track) / np.diff(track.t_s)))
    _none(
        speed > FASTEST_MPS,
        source,
        place,
        lambda k: f"{speed[k]:,.0f} m/s from the point before (at most {FASTEST_MPS:,.0f})",
    )
    return track


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
    """Distances between neighbours, m."""
    per_north, per_east = radians_per_metre(float(track.latitude[0]), float(track.height[0]))
    north, east = np.diff(track.latitude) / per_north, np.diff(np.unwrap(track.longitude)) / per_east
    steps: Floats = np.sqrt(north**2 + east**2 + np.diff(track.height) ** 2)
    return steps
