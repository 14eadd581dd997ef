"""The sky above a receiver in the course of a run, computed once for a while: satellites move by a quarter of
a degree in that time. The same `Sky` comes again as long as it holds, so that who prints it need not do so
anew.
"""

from __future__ import annotations

from collections.abc import Sequence

from host.sim.gnss.constellation import NO_DOP, Sky, blocked, sky_at

NS = 1_000_000_000
SKY_STEP_NS = 30 * NS


class SlowSky:
    """Satellites in view as a function of time."""

    def __init__(self, start_gps_ns: int, constellations: Sequence[str], elevation_mask: float) -> None:
        """`elevation_mask`: the lowest elevation tracked, rad."""
        self._start_gps_ns = start_gps_ns
        self._constellations = list(constellations)
        self._elevation_mask = elevation_mask
        self._index = -1
        self._open = self._hidden = Sky((), NO_DOP, NO_DOP, NO_DOP, NO_DOP)

    def above(self, time_ns: int, latitude: float, longitude: float, height: float, is_open: bool) -> Sky:
        """The sky at an instant; not `is_open`: from inside a tunnel."""
        index = time_ns // SKY_STEP_NS
        if index != self._index:
            gps_time_s = (self._start_gps_ns + index * SKY_STEP_NS) * 1e-9
            place = latitude, longitude, height
            self._open = sky_at(gps_time_s, *place, self._constellations, self._elevation_mask)
            self._hidden = blocked(self._open)
            self._index = index
        return self._open if is_open else self._hidden
