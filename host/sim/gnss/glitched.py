"""A receiver, simulated or recorded, that the scenario makes report wrongly for a while."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from boards.chips.world import GnssEpoch, GnssWorld
from host.sim.earth import radians_per_metre
from host.sim.gnss.baseline import NO_BASELINE, turned
from host.sim.gnss.schedule import NS, Glitch


class GlitchedReceiver:
    """Implements `boards.chips.world.GnssWorld` on top of another."""

    def __init__(self, receiver: GnssWorld, glitches: Sequence[Glitch]) -> None:
        self._receiver = receiver
        self.glitches = list(glitches)
        """Each counts the epochs that it struck."""

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The receiver's epoch, with every glitch of that instant added."""
        epoch = self._receiver.epoch(time_ns)
        for glitch in self.glitches:
            if glitch.window.holds(time_ns) and _can_strike(glitch, epoch):
                glitch.fired += 1
                epoch = _struck(epoch, glitch, time_ns)
        return epoch


def _struck(epoch: GnssEpoch, glitch: Glitch, time_ns: int) -> GnssEpoch:
    if glitch.jamming is not None:
        return glitch.jamming.jammed(epoch)
    epoch = _baseline_struck(epoch, glitch)
    pull = glitch.pull_ned_mps
    pulled_s = (time_ns - glitch.window.start_ns) / NS
    north, east, down = (
        offset + pulled_s * rate for offset, rate in zip(glitch.offset_ned_m, pull, strict=True)
    )
    vn, ve, vd = epoch.velocity_ned
    lat_per_m, lon_per_m = radians_per_metre(epoch.latitude, epoch.height)
    return replace(
        epoch,
        gps_time_ns=epoch.gps_time_ns + glitch.time_offset_ns,
        latitude=epoch.latitude + north * lat_per_m,
        longitude=epoch.longitude + east * lon_per_m,
        height=epoch.height - down,
        velocity_ned=(vn + pull[0], ve + pull[1], vd + pull[2]),
    )


def _can_strike(glitch: Glitch, epoch: GnssEpoch) -> bool:
    """Faults of the second antenna need a baseline."""
    at_baseline = glitch.baseline_lost or _changes_baseline(glitch)
    return not at_baseline or (epoch.baseline is not None and epoch.baseline.fix != "NONE")


def _baseline_struck(epoch: GnssEpoch, glitch: Glitch) -> GnssEpoch:
    if glitch.baseline_lost:
        return replace(epoch, baseline=NO_BASELINE)
    if epoch.baseline is None or not _changes_baseline(glitch):
        return epoch
    length = max(0.0, epoch.baseline.length + glitch.baseline_stretch_m)
    return replace(epoch, baseline=replace(turned(epoch.baseline, *glitch.baseline_turn), length=length))


def _changes_baseline(glitch: Glitch) -> bool:
    return any(glitch.baseline_turn) or glitch.baseline_stretch_m != 0.0
