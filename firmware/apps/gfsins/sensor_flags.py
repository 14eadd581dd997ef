"""Flags of a solution that tell of the sensors, where the master of the federation cannot know of them.

The master gets no measurement of its own: by its own flags the receiver would be lost for ever. Here they are
told by what has come in packets, and by what the two filters made of it:

    gnss_lost           no epoch with a position for 3 s
    gnss_rejected       its last two epochs were refused
    attitude_lost       no reading of the compass for 2 s
    attitude_rejected   its last two readings were refused, or repeat themselves
    imu_gap             packets were missing within the last 2 s, or a chip gives no samples
    imu_stuck           a chip repeats itself
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from firmware.apps.gfsins.acquisition_news import AcquisitionNews
from firmware.apps.gfsins.reception import Reception
from firmware.nav import flags
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import packet as pk
from hal.clock import Clock

NEVER_NS = -(10**15)
GNSS_LOST_NS = 3_000_000_000
COMPASS_LOST_NS = 2_000_000_000
GAP_HOLD_NS = 2_000_000_000
REFUSALS = 2
OWN = (
    flags.GNSS_LOST, flags.GNSS_REJECTED, flags.ATTITUDE_LOST, flags.ATTITUDE_REJECTED, flags.IMU_GAP,
)  # fmt: skip
CORE = ~sum(1 << flag for flag in OWN)
"""What the navigation core knows by itself."""


class SensorFlags:
    """Knows when what came last."""

    def __init__(
        self,
        clock: Clock,
        reception: Reception,
        news: AcquisitionNews,
        counts: NDArray[Any],
        uses_registers: bool,
    ) -> None:
        """`counts`: those of the federation. `uses_registers`: a sample that is none is a chip's doing."""
        self._clock = clock
        self._reception = reception
        self._news = news
        self._counts = counts
        self._uses_registers = uses_registers
        self._epoch_ns = self._reading_ns = NEVER_NS

    def note(self, told: int, tick_ns: int) -> None:
        """Compass or GPS came in the packet of that tick."""
        if told & pk.HAS_COMPASS:
            self._reading_ns = tick_ns
        if told & pk.HAS_GPS:
            self._epoch_ns = tick_ns

    def of(self, core: int) -> int:
        """The flags of a solution, `core` being those of the master."""
        now_ns = self._clock.now_ns()
        reception, news = self._reception, self._news
        compass, gps = self._counts[gl.REFUSED_IN_A_ROW : gl.REFUSED_IN_A_ROW + 2].tolist()
        gap = now_ns - reception.gap_ns < GAP_HOLD_NS or now_ns - reception.tick_ns > GAP_HOLD_NS
        gap |= bool(int(reception.words[pk.FAULTS]) & ~news.stuck)
        word = core & CORE
        if self._uses_registers and word >> flags.IMU_NOT_FINITE & 1:
            word &= ~(1 << flags.IMU_NOT_FINITE)
            gap |= not news.stuck
        told = (
            (flags.GNSS_LOST, now_ns - self._epoch_ns > GNSS_LOST_NS),
            (flags.GNSS_REJECTED, gps >= REFUSALS),
            (flags.ATTITUDE_LOST, now_ns - self._reading_ns > COMPASS_LOST_NS),
            (flags.ATTITUDE_REJECTED, compass >= REFUSALS),
            (flags.IMU_GAP, gap),
            (flags.IMU_STUCK, news.stuck != 0),
        )
        for flag, stands in told:
            word |= int(stands) << flag
        return word
