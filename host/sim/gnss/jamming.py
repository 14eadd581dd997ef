"""A receiver whose satellites' signals are weaker than they were, by a jammer.

All C/N0 fall by the same number of dB. Below USED_DBHZ a satellite is tracked but not used, below
TRACKED_DBHZ it is lost; the dilutions are those of the satellites left, and without a solution of them
there is no fix. Position and velocity get more white noise, so that their σ grows by 10^(loss/20) and with
the dilution (the noise of a delay lock loop goes with 1/√(C/N0)); the claimed accuracies grow alike.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from boards.chips.world import BaselineSolution, GnssEpoch, Satellite
from host.sim.earth import radians_per_metre
from host.sim.gnss.baseline import NO_BASELINE, turned
from host.sim.gnss.constellation import NO_DOP, dilutions
from host.sim.seeding import NormalRows

USED_DBHZ, TRACKED_DBHZ = 25.0, 20.0
CHANNELS = (
    *(f"{kind}_{axis}" for kind in ("position", "velocity") for axis in ("north", "east", "down")),
    *("heading", "pitch"),
)


class Jamming:
    """One jammer that takes `loss_db` of every signal."""

    def __init__(self, loss_db: float, seed: int, name: str) -> None:
        self._loss_db = loss_db
        self._normals = NormalRows(seed, [f"{name}.jamming.{channel}" for channel in CHANNELS])

    def jammed(self, epoch: GnssEpoch) -> GnssEpoch:
        """What the receiver makes of it."""
        satellites = [self._weaker(satellite) for satellite in epoch.satellites]
        pdop, hdop, vdop, tdop = dilutions(satellites)
        normals = self._normals.next()
        weak = replace(
            epoch, satellites=tuple(satellites), pdop=pdop, hdop=hdop, vdop=vdop, tdop=tdop, fix=False
        )
        if not epoch.fix or hdop == NO_DOP:
            return weak if weak.baseline is None else replace(weak, baseline=NO_BASELINE)
        growth = 10.0 ** (self._loss_db / 20.0)
        h, v, s = (
            growth * max(1.0, now / before)
            for now, before in ((hdop, epoch.hdop), (vdop, epoch.vdop), (pdop, epoch.pdop))
        )
        baseline = None if weak.baseline is None else _noisier_baseline(weak.baseline, s, normals[6:])
        return replace(_noisier(weak, (h, v, s), normals), fix=True, baseline=baseline)

    def _weaker(self, satellite: Satellite) -> Satellite:
        left = satellite.cn0_dbhz - self._loss_db
        if left < TRACKED_DBHZ:
            return replace(satellite, cn0_dbhz=0.0, used=False)
        return replace(satellite, cn0_dbhz=left, used=satellite.used and left >= USED_DBHZ)


def _noisier(epoch: GnssEpoch, growths: tuple[float, float, float], normals: Sequence[float]) -> GnssEpoch:
    """σ of horizontal position, height and velocity times the growths (≥ 1)."""
    h, v, s = growths
    axis_h = epoch.h_acc / math.sqrt(2.0) * math.sqrt(h * h - 1.0)
    axis_v = epoch.v_acc * math.sqrt(v * v - 1.0)
    axis_s = epoch.s_acc / math.sqrt(3.0) * math.sqrt(s * s - 1.0)
    lat_per_m, lon_per_m = radians_per_metre(epoch.latitude, epoch.height)
    vn, ve, vd = epoch.velocity_ned
    return replace(
        epoch,
        latitude=epoch.latitude + axis_h * normals[0] * lat_per_m,
        longitude=epoch.longitude + axis_h * normals[1] * lon_per_m,
        height=epoch.height - axis_v * normals[2],
        velocity_ned=(vn + axis_s * normals[3], ve + axis_s * normals[4], vd + axis_s * normals[5]),
        h_acc=epoch.h_acc * h,
        v_acc=epoch.v_acc * v,
        s_acc=epoch.s_acc * s,
    )


def _noisier_baseline(
    solution: BaselineSolution, growth: float, normals: Sequence[float]
) -> BaselineSolution:
    """σ of heading and pitch times the growth (≥ 1)."""
    if solution.fix == "NONE":
        return solution
    more = math.sqrt(growth * growth - 1.0)
    weak = replace(solution, heading_acc=growth * solution.heading_acc, pitch_acc=growth * solution.pitch_acc)
    return turned(weak, more * solution.heading_acc * normals[0], more * solution.pitch_acc * normals[1])
