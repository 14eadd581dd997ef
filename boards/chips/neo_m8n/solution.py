"""The navigation solution of one epoch as the receiver holds it, before any message is printed.

It is what the receiver *shows* of the world's epoch: nothing before the first fix of a start, the time
only once it is known, the course frozen at low speed, only the satellite systems that are enabled.
"""

from __future__ import annotations

from boards.chips.receivers.utc import Utc
from boards.chips.world import GnssEpoch, Satellite

NO_FIX = 0
FIX_2D = 2
FIX_3D = 3
UNKNOWN_ACCURACY = 0xFFFF_FFFF
CLOCK_DRIFT_NS_PER_S = 165
"""A plausible oscillator; nothing in the emulated world depends on it."""
NANOSECONDS_PER_METRE = 1e9 / 299_792_458.0


class Solution:
    """One epoch. Angles in degrees, everything else SI; see the attributes' comments."""

    __slots__ = (
        "course_deg",
        "course_valid",
        "epoch",
        "fix",
        "gps_time_ns",
        "height",
        "latitude_deg",
        "leap_known",
        "leap_seconds",
        "longitude_deg",
        "position_known",
        "running_ms",
        "satellites",
        "separation",
        "sky_known",
        "speed",
        "time_known",
        "time_to_first_fix_ms",
        "tow_ms",
        "used",
        "utc",
        "week",
    )

    def __init__(self, epoch: GnssEpoch, gps_time_ns: int, utc: Utc, week: int, tow_ms: int) -> None:
        self.epoch = epoch
        self.gps_time_ns = gps_time_ns
        """As the receiver believes it; a clock of its own while `time_known` is False."""
        self.utc = utc
        self.week = week
        self.tow_ms = tow_ms
        self.fix = NO_FIX
        """0 none, 2 two-dimensional, 3 three-dimensional."""
        self.time_known = False
        self.leap_known = False
        """False while the leap seconds are the firmware's default."""
        self.leap_seconds = 0
        self.position_known = False
        """There is a position: the current one, or the last one before the fix was lost."""
        self.latitude_deg = 0.0
        self.longitude_deg = 0.0
        self.height = 0.0
        self.separation = 0.0
        self.speed = 0.0
        """Over ground, m/s."""
        self.course_deg = 0.0
        """Over ground; the last valid one while `course_valid` is False."""
        self.course_valid = False
        self.satellites: tuple[Satellite, ...] = ()
        self.used = 0
        self.sky_known = True
        """Elevations and azimuths are known (not so before the first fix of a cold start)."""
        self.running_ms = 0
        """Since the start of the navigation engine."""
        self.time_to_first_fix_ms = 0
        """0 until there was one."""

    @property
    def clock_bias_ns(self) -> int:
        """Receiver clock minus GPS time; it drifts and is put back in steps of one millisecond."""
        return (self.running_ms * CLOCK_DRIFT_NS_PER_S // 1000 + 500_000) % 1_000_000 - 500_000

    @property
    def clock_drift(self) -> float:
        """Drift of the receiver clock, ns/s."""
        return float(CLOCK_DRIFT_NS_PER_S)

    @property
    def time_accuracy_ns(self) -> int:
        """1 σ of the time: time dilution × range accuracy / c with a fix, 1 ms on the backup clock."""
        if self.fix:
            epoch = self.epoch
            return max(1, int(epoch.tdop * epoch.h_acc / max(epoch.hdop, 0.01) * NANOSECONDS_PER_METRE))
        return 1_000_000 if self.time_known else UNKNOWN_ACCURACY
