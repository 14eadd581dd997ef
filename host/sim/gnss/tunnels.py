"""Outages by place: when a vehicle is inside one of the polygons of a scenario's tunnels.

The place of the vehicle's origin is looked at every 0.1 s; a polygon's edges are straight in latitude and
longitude. A tunnel that is passed in less than that may be missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from host.sim.gnss.schedule import NS, Window

STEP_NS = NS // 10
AT_ONCE = 1 << 14
DEG = math.pi / 180.0

Floats = NDArray[np.float64]
Places = Callable[[NDArray[np.int64]], tuple[Floats, Floats]]
"""Virtual times in ns → latitudes and longitudes in rad."""
Polygon = Sequence[Sequence[float]]
"""Corners: latitude, longitude in °."""


def with_tunnels(
    outages: Sequence[Window], polygons: Sequence[Polygon], places: Places, duration_ns: int
) -> tuple[Window, ...]:
    """The outages, and those by place; where there are polygons, in order and joined where they meet."""
    if not polygons:
        return tuple(outages)
    found = [*outages, *_windows(polygons, places, duration_ns)]
    joined: list[Window] = []
    for one in sorted(found, key=lambda window: (window.start_ns, window.end_ns)):
        if joined and one.start_ns <= joined[-1].end_ns:
            joined[-1] = Window(joined[-1].start_ns, max(joined[-1].end_ns, one.end_ns))
        else:
            joined.append(one)
    return tuple(joined)


def _windows(polygons: Sequence[Polygon], places: Places, duration_ns: int) -> list[Window]:
    windows: list[Window] = []
    start_ns: int | None = None
    for first in range(0, duration_ns, AT_ONCE * STEP_NS):
        times_ns = np.arange(first, min(duration_ns, first + AT_ONCE * STEP_NS), STEP_NS, dtype=np.int64)
        latitude, longitude = places(times_ns)
        covered = np.zeros(len(times_ns), dtype=bool)
        for polygon in polygons:
            covered |= inside(np.asarray(polygon, dtype=np.float64), latitude / DEG, longitude / DEG)
        changes = np.flatnonzero(np.diff(covered, prepend=start_ns is not None))
        for time_ns in times_ns[changes].tolist():
            if start_ns is None:
                start_ns = time_ns
            else:
                windows.append(Window(start_ns, time_ns))
                start_ns = None
    if start_ns is not None:
        windows.append(Window(start_ns, duration_ns))
    return windows


def inside(polygon: Floats, latitude: Floats, longitude: Floats) -> NDArray[np.bool_]:
    """Whether places (°) lie in a polygon (n, 2): an odd number of edges lies north of them."""
    x = _east_of(polygon[0, 1], longitude)
    corners_x, corners_y = _east_of(polygon[0, 1], polygon[:, 1]), polygon[:, 0]
    odd = np.zeros(len(latitude), dtype=bool)
    for x0, y0, x1, y1 in zip(
        corners_x, corners_y, np.roll(corners_x, -1), np.roll(corners_y, -1), strict=True
    ):
        if x0 == x1:
            continue
        spans = (x0 > x) != (x1 > x)
        odd ^= spans & (latitude < y0 + (x - x0) * (y1 - y0) / (x1 - x0))
    return odd


def _east_of(origin: float, longitude: Floats) -> Floats:
    """Longitudes from another one, −180 … 180."""
    east: Floats = (longitude - origin + 180.0) % 360.0 - 180.0
    return east
