"""The navigation processor's door in flight: one good packet through everything that it brings about.

door = PacketDoor(federation)
told = door.take(words, felt)      # bits: what was done, see below
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.gyro_free import layout as gl
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
from hal.machine_code import mypyc_attr

SAMPLE_USED: Final = USED
COMPASS_BELIEVED: Final = 2
GPS_BELIEVED: Final = 4
FUSED: Final = 8
NS_PER_AGE: Final = 100_000
RESTARTED_NS: Final = 1_000_000_000
UNKNOWN_GAP_NS: Final = 500_000_000


@mypyc_attr(allow_interpreted_subclasses=True)
class PacketDoor:
    """Kernels and arrays of one federation."""

    def __init__(self, federation: Federation) -> None:
        self.epoch = np.zeros(gnss.RECORD_SIZE, np.int64)
        """The GPS part of the last packet that had one."""
        self._arrived_ns: int | None = None
        self._g, self._n = federation.g, federation.n
        self._f1, self._i1 = federation.compass
        self._f2, self._i2 = federation.gps
        self._fm, self._im = federation.master
        self._inertial = entry_point(packet_step)
        self._compass = entry_point(compass_step)
        self._gps = entry_point(gps_step)
        self._fuse = entry_point(fusion_step)
        self._read_epoch = entry_point(epoch_of_packet)

    def take(self, words: NDArray[np.int64], felt: NDArray[np.float32], arrived_ns: int | None = None) -> int:
        """Bits of what was done: 1 sample used, 2 compass believed, 4 GPS believed, 8 fused.

        `arrived_ns`: when the packet came, by any clock that goes on while the acquisition is reset. A packet
        whose time lies more than a second back is the first of an acquisition that began anew; its time is
        counted from there, by that clock, or as if half a second had been lost.
        """
        g, n, f1, i1, f2, i2 = self._g, self._n, self._f1, self._i1, self._f2, self._i2
        fm, im = self._fm, self._im
        due: int = self._inertial(g, n, words, felt, f1, i1, f2, i2, fm, im)
        if not due and self._has_restarted(words, arrived_ns):
            due = self._inertial(g, n, words, felt, f1, i1, f2, i2, fm, im)
        self._arrived_ns = arrived_ns
        done = due & SAMPLE_USED
        if due <= SAMPLE_USED:
            return done
        t = self._tick_ns(words)
        if due & COMPASS_DUE:
            heading, pitch, roll = words[pk.HEADING : pk.ROLL + 1].astype(np.int16).tolist()
            valid = t - int(words[pk.COMPASS_AGE]) * NS_PER_AGE
            done |= COMPASS_BELIEVED * self._compass(g, n, f1, i1, heading, pitch, roll, valid)
        if due & GPS_DUE:
            self._read_epoch(words, self.epoch, t)
            done |= GPS_BELIEVED * self._gps(g, n, f2, i2, self.epoch)
        if due & FUSION_DUE:
            done |= FUSED * self._fuse(g, n, f1, i1, f2, i2, fm, im)
        return done

    def _has_restarted(self, words: NDArray[np.int64], arrived_ns: int | None) -> bool:
        """Whether a packet from the past, of which nothing was used, is the first of an acquisition that
        began anew; then its time is moved behind the last one's."""
        n, t = self._n, self._tick_ns(words)
        if t >= int(n[gl.TICK]) - RESTARTED_NS:
            return False
        lost = UNKNOWN_GAP_NS
        if arrived_ns is not None and self._arrived_ns is not None:
            lost = max(arrived_ns - self._arrived_ns, int(n[gl.TICK_NS]))
        n[gl.TICK_OFFSET] += int(n[gl.TICK]) + lost - t
        n[gl.RESTARTS] += 1
        return True

    def _tick_ns(self, words: NDArray[np.int64]) -> int:
        """Of the packet."""
        high, middle, low = words[pk.TIME : pk.TIME + 3].tolist()
        offset = int(self._n[gl.TICK_OFFSET])
        return (high << 32 | middle << 16 | low) * 1000 + offset
