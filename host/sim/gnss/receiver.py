"""Solutions of a simulated receiver: truth at the antenna, errors, outages and the sky.

Claimed accuracies are honest 1 σ figures: `h_acc` of the horizontal error vector (√2 times one axis),
`v_acc` of the height, `s_acc` of the velocity vector (√3 times one axis).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from boards.chips.world import GnssEpoch
from host.sim.earth import radians_per_metre
from host.sim.errors.processes import Process, ProcessBank
from host.sim.gnss.ahead import AntennaAhead, AntennaTruth
from host.sim.gnss.baseline import Baseline, BaselineTruth
from host.sim.gnss.schedule import Window, held
from host.sim.gnss.settings import GnssSettings
from host.sim.gnss.slow_sky import NS, SlowSky
from host.sim.seeding import NormalRows, generator

LEAST_LATENCY_S = 0.01


@dataclass(frozen=True, slots=True)
class SecondAntenna:
    """Where it is, seen from the main one."""

    truth: BaselineTruth
    length_m: float


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
        second: SecondAntenna | None = None,
    ) -> None:
        self._settings = settings
        self._start_gps_ns = start_gps_ns
        self._leap_seconds = leap_seconds
        self._geoid_separation = geoid_separation
        reacquisition_ns = round(settings.reacquisition_s * NS)
        self._outages = [Window(w.start_ns, w.end_ns + reacquisition_ns) for w in outages]
        self._blocked = list(outages)
        self._baseline = None
        if second is not None:
            errors = settings.baseline
            self._baseline = Baseline(name, errors, second.truth, second.length_m, seed, self._outages)
        sigma, time = settings.position_markov_m, settings.position_markov_time_s
        factors = {"north": 1.0, "east": 1.0, "down": settings.vertical_factor}
        slow = ProcessBank(
            [Process(f"{name}.position_{axis}.markov", sigma * k, time) for axis, k in factors.items()], seed
        )
        self._ahead = AntennaAhead(antenna, slow)
        self._normals = NormalRows(
            seed,
            [
                *(f"{name}.position_{axis}.white" for axis in factors),
                *(f"{name}.velocity_{axis}.white" for axis in factors),
                f"{name}.latency_jitter",
            ],
        )
        self._vertical_white_m = settings.position_white_m * settings.vertical_factor
        axis_m = math.hypot(settings.position_white_m, settings.position_markov_m)
        self._h_acc = math.sqrt(2.0) * axis_m
        self._v_acc = settings.vertical_factor * axis_m
        self._s_acc = math.sqrt(3.0) * settings.velocity_white_mps
        draw = float(generator(seed, f"{name}.latency").standard_normal())
        self.latency_s = max(LEAST_LATENCY_S, settings.latency_s + settings.latency_sigma_s * draw)
        """This run's latency without jitter."""
        mask = math.radians(settings.elevation_mask_deg)
        self._sky = SlowSky(start_gps_ns, settings.constellations, mask)

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The solution valid at `time_ns`; without signal an epoch without fix whose clock runs on."""
        lat, lon, height, vn, ve, vd, slow_n, slow_e, slow_d = self._ahead.at(time_ns)
        white_n, white_e, white_d, noise_n, noise_e, noise_d, jitter = self._normals.next()
        sky = self._sky.above(time_ns, lat, lon, height, is_open=not held(self._blocked, time_ns))
        lat_per_m, lon_per_m = radians_per_metre(lat, height)
        white_m, white_mps = self._settings.position_white_m, self._settings.velocity_white_mps
        return GnssEpoch(
            fix=not held(self._outages, time_ns),
            time_known=True,
            gps_time_ns=self._start_gps_ns + time_ns,
            leap_seconds=self._leap_seconds,
            latitude=lat + (slow_n + white_m * white_n) * lat_per_m,
            longitude=math.remainder(lon + (slow_e + white_m * white_e) * lon_per_m, 2.0 * math.pi),
            height=height - (slow_d + self._vertical_white_m * white_d),
            geoid_separation=self._geoid_separation,
            velocity_ned=(vn + white_mps * noise_n, ve + white_mps * noise_e, vd + white_mps * noise_d),
            h_acc=self._h_acc,
            v_acc=self._v_acc,
            s_acc=self._s_acc,
            pdop=sky.pdop,
            hdop=sky.hdop,
            vdop=sky.vdop,
            tdop=sky.tdop,
            satellites=sky.satellites,
            latency_ns=self._latency_ns(jitter),
            baseline=None if self._baseline is None else self._baseline.at(time_ns),
        )

    def forget_ahead(self) -> None:
        """Where the antenna will be has changed."""
        self._ahead.forget()
        if self._baseline is not None:
            self._baseline.forget_ahead()

    def _latency_ns(self, jitter: float) -> int:
        return round(max(LEAST_LATENCY_S, self.latency_s + self._settings.latency_jitter_s * jitter) * NS)
