"""The navigation processor's door in flight: one good packet through everything that it brings about.

door = PacketDoor(federation)
told = door.take(words, felt)      # bits: what was done, see below
"""

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.filters import Federation
from firmware.nav.gyro_free.packet_step import (
    COMPASS_DUE,
    FUSION_DUE,
    GPS_DUE,
    USED,
    epoch_of_packet,
    packet_step,
)
from firmware.nav.gyro_free.steps import compass_step, fusion_step, gps_step
from firmware.numerics.dialect import entry_point

SAMPLE_USED = USED
COMPASS_BELIEVED = 2
GPS_BELIEVED = 4
FUSED = 8
NS_PER_AGE = 100_000


class PacketDoor:
    """Kernels and arrays of one federation."""

    def __init__(self, federation: Federation) -> None:
        self.epoch = np.zeros(gnss.RECORD_SIZE, np.int64)
        """The GPS part of the last packet that had one."""
        self._federation = federation
        self._all = federation.all
        self._inertial = entry_point(packet_step)
        self._compass = entry_point(compass_step)
        self._gps = entry_point(gps_step)
        self._fuse = entry_point(fusion_step)
        self._read_epoch = entry_point(epoch_of_packet)

    def take(self, words: NDArray[np.int64], felt: NDArray[np.float32]) -> int:
        """Bits of what was done: 1 sample used, 2 compass believed, 4 GPS believed, 8 fused."""
        federation = self._federation
        g, n = federation.g, federation.n
        due = self._inertial(g, n, words, felt, *self._all)
        done: int = due & USED
        if due <= USED:
            return done
        t = ((int(words[pk.TIME]) << 32) | (int(words[pk.TIME + 1]) << 16) | int(words[pk.TIME + 2])) * 1000
        if due & COMPASS_DUE:
            heading, pitch, roll = (int(word) for word in words[pk.HEADING : pk.ROLL + 1].astype(np.int16))
            valid = t - int(words[pk.COMPASS_AGE]) * NS_PER_AGE
            done |= COMPASS_BELIEVED * self._compass(g, n, *federation.compass, heading, pitch, roll, valid)
        if due & GPS_DUE:
            self._read_epoch(words, self.epoch, t)
            done |= GPS_BELIEVED * self._gps(g, n, *federation.gps, self.epoch)
        if due & FUSION_DUE:
            done |= FUSED * self._fuse(g, n, *self._all)
        return done
