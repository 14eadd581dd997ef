"""Solutions of a simulated receiver: truth at the antenna, errors, outages and the sky.

Claimed accuracies are honest 1 σ figures: `h_acc` of the horizontal error vector (√2 times one axis),
`v_acc` of the height, `s_acc` of the velocity vector (√3 times one axis).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch
from host.sim.earth import radians_per_metre
from host.sim.errors.processes import Process, ProcessBank
from host.sim.gnss.constellation import Sky, blocked, sky_at
from host.sim.gnss.schedule import Window
from host.sim.gnss.settings import GnssSettings
from host.sim.seeding import generator
from host.sim.trajectory.motion import CHUNK_SHIFT

NS = 1_000_000_000
SKY_STEP_NS = 30 * NS
"""Satellites move by a quarter of a degree in this time; the sky is computed once for it."""
LEAST_LATENCY_S = 0.01

AntennaTruth = Callable[[int], Sequence[float]]
"""Virtual time in ns → latitude, longitude (rad), height (m), v_N, v_E, v_D (m/s) of the antenna."""


class SimulatedReceiver:
    """Implements `boards.chips.world.GnssWorld`."""

    def __init__(
        self,
        name: str,
        settings: GnssSettings,
        antenna: AntennaTruth,
        start_gps_ns: int,
        leap_seconds: int,
        geoid_separation: float,
        seed: int,
        outages: Sequence[Window] = (),
    ) -> None:
        self._settings = settings
        self._antenna = antenna
        self._start_gps_ns = start_gps_ns
        self._leap_seconds = leap_seconds
        self._geoid_separation = geoid_separation
        reacquisition_ns = round(settings.reacquisition_s * NS)
        self._outages = [Window(w.start_ns, w.end_ns + reacquisition_ns) for w in outages]
        self._blocked = list(outages)
        sigma, time = settings.position_markov_m, settings.position_markov_time_s
        factors = {"north": 1.0, "east": 1.0, "down": settings.vertical_factor}
        self._slow = ProcessBank(
            [Process(f"{name}.position_{axis}.markov", sigma * k, time) for axis, k in factors.items()], seed
        )
        self._white = [generator(seed, f"{name}.position_{axis}.white") for axis in factors]
        self._velocity = [generator(seed, f"{name}.velocity_{axis}.white") for axis in factors]
        draw = float(generator(seed, f"{name}.latency").standard_normal())
        self.latency_s = max(LEAST_LATENCY_S, settings.latency_s + settings.latency_sigma_s * draw)
        """This run's latency without jitter."""
        self._jitter = generator(seed, f"{name}.latency_jitter")
        self._sky_index = -1
        self._sky = Sky((), 0.0, 0.0, 0.0, 0.0)

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The solution valid at `time_ns`; without signal an epoch without fix whose clock runs on."""
        lat, lon, height, *velocity = self._antenna(time_ns)
        fix = not any(w.holds(time_ns) for w in self._outages)
        sky = self._sky_at(time_ns, lat, lon, height)
        if any(w.holds(time_ns) for w in self._blocked):
            sky = blocked(sky)
        north, east, down = self._position_error(time_ns)
        lat_per_m, lon_per_m = radians_per_metre(lat, height)
        s = self._settings
        axis = math.hypot(s.position_white_m, s.position_markov_m)
        noisy = [
            v + s.velocity_white_mps * float(g.standard_normal())
            for v, g in zip(velocity, self._velocity, strict=True)
        ]
        return GnssEpoch(
            fix=fix,
            time_known=True,
            gps_time_ns=self._start_gps_ns + time_ns,
            leap_seconds=self._leap_seconds,
            latitude=lat + north * lat_per_m,
            longitude=lon + east * lon_per_m,
            height=height - down,
            geoid_separation=self._geoid_separation,
            velocity_ned=(noisy[0], noisy[1], noisy[2]),
            h_acc=math.sqrt(2.0) * axis,
            v_acc=s.vertical_factor * axis,
            s_acc=math.sqrt(3.0) * s.velocity_white_mps,
            pdop=sky.pdop,
            hdop=sky.hdop,
            vdop=sky.vdop,
            tdop=sky.tdop,
            satellites=sky.satellites,
            latency_ns=self._latency_ns(),
        )

    def _position_error(self, time_ns: int) -> tuple[float, float, float]:
        """North, east, down in m."""
        chunk = time_ns >> CHUNK_SHIFT
        nodes = self._slow.nodes(chunk)
        k, rest = divmod(time_ns - (chunk << CHUNK_SHIFT), 1 << self._slow.node_shift)
        x = rest / (1 << self._slow.node_shift)
        slow: NDArray[np.float64] = nodes[k] + x * (nodes[k + 1] - nodes[k])
        white = self._settings.position_white_m
        factors = (1.0, 1.0, self._settings.vertical_factor)
        north, east, down = (
            float(slow[i]) + white * factors[i] * float(self._white[i].standard_normal()) for i in range(3)
        )
        return north, east, down

    def _latency_ns(self) -> int:
        jitter = self._settings.latency_jitter_s * float(self._jitter.standard_normal())
        return round(max(LEAST_LATENCY_S, self.latency_s + jitter) * NS)

    def _sky_at(self, time_ns: int, lat: float, lon: float, height: float) -> Sky:
        index = time_ns // SKY_STEP_NS
        if index != self._sky_index:
            gps_time_s = (self._start_gps_ns + index * SKY_STEP_NS) * 1e-9
            mask = math.radians(self._settings.elevation_mask_deg)
            self._sky = sky_at(gps_time_s, lat, lon, height, list(self._settings.constellations), mask)
            self._sky_index = index
        return self._sky
