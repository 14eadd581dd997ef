"""A receiver, simulated or recorded, that the scenario makes report a wrong time or position for a while."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from boards.chips.world import GnssEpoch, GnssWorld
from host.sim.earth import radians_per_metre
from host.sim.gnss.schedule import Glitch


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
            if glitch.window.holds(time_ns):
                glitch.fired += 1
                epoch = _struck(epoch, glitch)
        return epoch


def _struck(epoch: GnssEpoch, glitch: Glitch) -> GnssEpoch:
    north, east, down = glitch.offset_ned_m
    lat_per_m, lon_per_m = radians_per_metre(epoch.latitude, epoch.height)
    return replace(
        epoch,
        gps_time_ns=epoch.gps_time_ns + glitch.time_offset_ns,
        latitude=epoch.latitude + north * lat_per_m,
        longitude=epoch.longitude + east * lon_per_m,
        height=epoch.height - down,
    )
