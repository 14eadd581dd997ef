"""The way so far in a plane: metres north and east of the first position, fused and GNSS.

Each line holds at most MOST points. When it is full every second point goes and the least distance between
points doubles, so that a day's drive keeps its shape.
"""

from __future__ import annotations

import math

EARTH_RADIUS_M = 6_371_000.0
NANODEG = math.pi / 180.0 * 1e-9
MOST = 800
LEAST_STEP_M = 0.5
HALF_TURN_NANODEG = 180_000_000_000
QUARTER_NANODEG = 90_000_000_000


class Line:
    """Points (north, east) in m, no two in a row nearer than `step_m`."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float]] = []
        self.now: tuple[float, float] | None = None
        """The latest position, kept or not."""
        self.step_m = LEAST_STEP_M

    def add(self, north: float, east: float) -> bool:
        """Whether the point was kept."""
        self.now = north, east
        if self.points:
            last_north, last_east = self.points[-1]
            if math.hypot(north - last_north, east - last_east) < self.step_m:
                return False
        self.points.append((north, east))
        if len(self.points) > MOST:
            del self.points[1::2]
            self.step_m *= 2
        return True


class Track:
    """Both lines, the same origin."""

    def __init__(self) -> None:
        self.fused = Line()
        self.gnss = Line()
        self.yaw = 0.0
        self.version = 0
        """Counts points kept: what was drawn for an equal version need not be drawn again."""
        self._origin: tuple[int, int, float] | None = None

    def add_fused(self, lat_nanodeg: int, lon_nanodeg: int, yaw: float) -> None:
        """A position of the board and where its nose points, rad."""
        self.yaw = yaw
        self._add(self.fused, lat_nanodeg, lon_nanodeg)

    def add_gnss(self, lat_nanodeg: int, lon_nanodeg: int) -> None:
        """A position of the receiver."""
        self._add(self.gnss, lat_nanodeg, lon_nanodeg)

    def _add(self, line: Line, lat_nanodeg: int, lon_nanodeg: int) -> None:
        if abs(lat_nanodeg) > QUARTER_NANODEG or abs(lon_nanodeg) > HALF_TURN_NANODEG:
            return
        if self._origin is None:
            self._origin = lat_nanodeg, lon_nanodeg, math.cos(lat_nanodeg * NANODEG)
        lat_0, lon_0, cosine = self._origin
        turn = 2 * HALF_TURN_NANODEG
        east_nanodeg = (lon_nanodeg - lon_0 + HALF_TURN_NANODEG) % turn - HALF_TURN_NANODEG
        north = (lat_nanodeg - lat_0) * NANODEG * EARTH_RADIUS_M
        east = east_nanodeg * NANODEG * EARTH_RADIUS_M * cosine
        self.version += line.add(north, east)
