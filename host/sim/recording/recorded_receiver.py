"""A recorded GNSS receiver: its solutions at the instants at which a chip model asks for them.

What the recording lacks is stated, not recorded: accuracies are constants, measured once against the
reference (RMS: horizontal 0.43 m, height 1.1 m, both with their constant parts; velocity 0.15 m/s) and, as
receivers do, doubled for the position; the satellites in view are those of the simulated sky.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch
from host.sim.gnss.schedule import NS, Window, held
from host.sim.gnss.slow_sky import SlowSky

Array = NDArray[np.float64]
LARGEST_GAP_S = 0.35
"""Neighbouring solutions may be this far apart to be interpolated; else there is no solution."""
H_ACC_M, V_ACC_M, S_ACC_MPS = 1.0, 2.2, 0.15
LEAST_LATENCY_NS = 1_000_000


class RecordedReceiver:
    """Implements `boards.chips.world.GnssWorld`."""

    def __init__(
        self,
        valid_ns: Array,
        arrival_ns: Array,
        position: Array,
        velocity: Array,
        start_gps_ns: int,
        leap_seconds: int,
        geoid_separation: float,
        constellations: Sequence[str],
        elevation_mask: float,
        outages: Sequence[Window],
        reacquisition_ns: int,
    ) -> None:
        """Times in virtual ns; position (n, 3) lat, lon rad, height m; velocity (n, 3) NED m/s."""
        self._valid_ns = valid_ns
        self._columns = np.column_stack((position, velocity, arrival_ns - valid_ns))
        self._start_gps_ns = start_gps_ns
        self._leap_seconds = leap_seconds
        self._geoid_separation = geoid_separation
        self._sky = SlowSky(start_gps_ns, constellations, elevation_mask)
        self._blocked = list(outages)
        self._outages = [Window(w.start_ns, w.end_ns + reacquisition_ns) for w in outages]

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The recorded solution at `time_ns`, linear between its neighbours; no fix in outages and gaps."""
        state, in_reach = self._interpolated(time_ns)
        lat, lon, height, vn, ve, vd, latency_ns = state
        sky = self._sky.above(time_ns, lat, lon, height, is_open=not held(self._blocked, time_ns))
        return GnssEpoch(
            fix=in_reach and not held(self._outages, time_ns),
            time_known=True,
            gps_time_ns=self._start_gps_ns + time_ns,
            leap_seconds=self._leap_seconds,
            latitude=lat,
            longitude=lon,
            height=height,
            geoid_separation=self._geoid_separation,
            velocity_ned=(vn, ve, vd),
            h_acc=H_ACC_M,
            v_acc=V_ACC_M,
            s_acc=S_ACC_MPS,
            pdop=sky.pdop,
            hdop=sky.hdop,
            vdop=sky.vdop,
            tdop=sky.tdop,
            satellites=sky.satellites,
            latency_ns=max(LEAST_LATENCY_NS, round(latency_ns)),
        )

    def _interpolated(self, time_ns: int) -> tuple[list[float], bool]:
        """Position, velocity, latency at an instant, and whether recorded solutions lie close enough."""
        valid = self._valid_ns
        k = min(max(int(np.searchsorted(valid, time_ns, side="right")) - 1, 0), len(valid) - 2)
        span = valid[k + 1] - valid[k]
        x = min(max((time_ns - valid[k]) / span, 0.0), 1.0)
        state: list[float] = (self._columns[k] + x * (self._columns[k + 1] - self._columns[k])).tolist()
        nearest = min(abs(time_ns - valid[k]), abs(time_ns - valid[k + 1]))
        inside = valid[0] <= time_ns <= valid[-1]
        return state, nearest < 0.001 * NS or (inside and span <= LARGEST_GAP_S * NS)
