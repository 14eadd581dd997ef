"""Before navigation: some seconds at rest or straight on, at one speed.

Heading, roll and pitch are the compass's means; the six accelerometers on the arms are made equal to those at
the origin, so that ω̇ and the products are zero; those at the origin are made to show gravity in that
attitude. Place and velocity are the receiver's.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.gyro_free import alignment as rest
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.filters import Beginning, Federation
from firmware.nav.gyro_free.packet_step import epoch_of_packet
from firmware.numerics.dialect import entry_point

GRAVITY = 9.80665
ENOUGH_READINGS = 15
LARGEST_CHANGE = 0.7
"""m/s of speed between two epochs: driving off or braking."""
FARTHEST_OFFSET = 0.3 * GRAVITY
"""An accelerometer on an arm that differs more from that at the origin is not where it should be."""
TENTH = math.pi / 1800.0
MM = 1e-3
NAMES = tuple(f"A{k + 1}" for k in range(9))


class Alignment:
    """Gathers packets until `finish` gives a beginning."""

    def __init__(self, federation: Federation, needed_ns: int, uses_registers: bool) -> None:
        self.misplaced: tuple[str, ...] = ()
        """Accelerometers that read what they cannot read where they should be."""
        self.restarts = 0
        self.readings = 0
        self.has_fix = False
        self._federation = federation
        self._needed_ns = needed_ns
        self._uses_registers = uses_registers
        self._gather = entry_point(rest.gather_rest)
        self._finish = entry_point(rest.finish_alignment)
        self._read_epoch = entry_point(epoch_of_packet)
        self._epoch = gnss.new_epoch()
        self._speed = -1.0
        self._begin()

    def _begin(self) -> None:
        self._sums = np.zeros(rest.SIZE, np.float32)
        self._tilt = [0.0, 0.0]
        self.readings = 0
        self._since_ns = -1

    def take(self, words: NDArray[np.int64], tick_ns: int) -> Beginning | None:
        """One packet; a beginning when all is known."""
        if self._since_ns < 0:
            self._since_ns = tick_ns
        self._gather(self._federation.g, words, self._sums)
        flags = int(words[pk.FLAGS])
        if flags & pk.HAS_COMPASS:
            self.readings += 1
            for k in range(2):
                self._tilt[k] += float(words[pk.PITCH + k].astype(np.int16)) * TENTH
        if flags & pk.HAS_GPS:
            self._take_epoch(words, tick_ns)
        ready = self.has_fix and self.readings >= ENOUGH_READINGS and flags & pk.HAS_GPS
        return self._finished(tick_ns) if ready and tick_ns - self._since_ns >= self._needed_ns else None

    def _take_epoch(self, words: NDArray[np.int64], tick_ns: int) -> None:
        self._read_epoch(words, self._epoch, tick_ns)
        self.has_fix = True
        speed = float(self._epoch[gnss.SPEED_MMPS]) * MM
        if self._speed >= 0.0 and abs(speed - self._speed) > LARGEST_CHANGE:
            self.restarts += 1
            self._begin()
        self._speed = speed

    def _finished(self, tick_ns: int) -> Beginning | None:
        federation, sums = self._federation, self._sums
        pitch, roll = (total / self.readings for total in self._tilt)
        angles = np.zeros(3, np.float32)
        if sums[rest.SAMPLES] >= 1.0:
            arms = np.append(sums[6:9], sums[6:9])
            far = np.flatnonzero(np.abs(sums[:6] - arms) > FARTHEST_OFFSET)
            self.misplaced = tuple(NAMES[k] for k in far)
            if len(far) and self._uses_registers:
                self._begin()
                return None
            self._finish(federation.g, federation.n, sums, angles)
            expected = GRAVITY * np.array(
                (
                    math.sin(pitch),
                    -math.cos(pitch) * math.sin(roll),
                    -math.cos(pitch) * math.cos(roll),
                )
            )
            offsets = sums[6:9] - expected
            federation.g[gl.OFFSET + 6 : gl.OFFSET + 9] += offsets
            federation.g[gl.OFFSET : gl.OFFSET + 6] += np.append(offsets, offsets)
        elif self._uses_registers:
            self._begin()
            return None
        heading = math.atan2(float(sums[rest.SINE]), float(sums[rest.COSINE]))
        epoch = self._epoch
        course = math.radians(int(epoch[gnss.COURSE_E5DEG]) * 1e-5)
        moved = self._speed * (tick_ns - int(epoch[gnss.VALID_NS])) * 1e-9
        north, east = math.cos(course), math.sin(course)
        latitude = int(epoch[gnss.LAT_NANODEG])
        metre = 1e9 * 180.0 / math.pi / 6.371e6
        return Beginning(
            tick_ns,
            round(latitude + moved * north * metre),
            round(
                int(epoch[gnss.LON_NANODEG]) + moved * east * metre / math.cos(math.radians(latitude * 1e-9))
            ),
            int(epoch[gnss.HEIGHT_MM]) * MM,
            (self._speed * north, self._speed * east, 0.0),
            (heading, pitch, roll),
        )
