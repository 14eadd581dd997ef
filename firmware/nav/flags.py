"""Modes, flags and events: what navigation says about itself.

A flag stands for what is so now (GNSS lost, standing still) or for an event within the last two seconds.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.numerics.dialect import kernel

WAITING = 0
LEVELLING = 1
WAITING_FOR_HEADING = 2
NAVIGATING = 3
DEGRADED = 4
"""Navigating on what is left: dead time of the IMU, a position that has grown too uncertain, or a receiver
that contradicts in position and velocity."""
MODE_NAMES = ("waiting", "levelling", "waiting for heading", "navigating", "degraded")

# Events: bit number = place in EVENT_TIME and EVENT_COUNT.
GNSS_TIME_JUMP = 0
GNSS_REJECTED = 1
"""Two epochs in a row: a gate of 99.9 % refuses one in a thousand that is well."""
GNSS_STALE = 2
"""Valid before the history begins, or after now."""
IMU_GAP = 3
IMU_SATURATED = 4
IMU_STUCK = 5
IMU_NOT_FINITE = 6
NUMERIC_RESTART = 7
"""The state was not finite; navigation began again."""
STANDSTILL = 8
CONSTRAINED = 9
"""A constraint of the vehicle was applied."""
REALIGNED = 10
"""Yaw was found wrong and set anew."""
REJOINED = 11
"""A gate was widened after many rejections in a row."""
GNSS_LOST = 12
POSITION_UNCERTAIN = 13
ATTITUDE_REJECTED = 14
"""Two headings of the attitude reference in a row; a flipped one or a wrong baseline at once."""
ATTITUDE_LOST = 15
"""The attitude reference has told no usable heading for a while."""
FLAG_NAMES = (
    "gnss_time_jump", "gnss_rejected", "gnss_stale", "imu_gap", "imu_saturated", "imu_stuck",
    "imu_not_finite", "numeric_restart", "standstill", "constrained", "realigned", "rejoined",
    "gnss_lost", "position_uncertain", "attitude_rejected", "attitude_lost",
)  # fmt: skip

HOLD_NS = np.int64(2_000_000_000)


@kernel
def report(i, event):
    """Note that `event` happens now."""
    i[at.EVENT_TIME + event] = i[at.TIME]
    i[at.EVENT_COUNT + event] += 1


@kernel
def is_recent(i, event):
    """Whether `event` happened within the last two seconds."""
    return i[at.TIME] - i[at.EVENT_TIME + event] <= HOLD_NS
