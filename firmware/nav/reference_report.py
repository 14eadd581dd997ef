"""What the attitude reference says: innovations, counters, and the gyro-compass as it gathers."""

import math

import numpy as np

from firmware.nav import flags as fl
from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav.gyrocompass import compass_turn, compass_variance
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import wrap_heading

ZERO = np.float32(0.0)
PI = np.float32(3.14159265358979)
THREE = np.int32(3)

# The float32 part of a report …
INNOVATION = 0
"""Of heading, pitch, roll, rad."""
SIGMA = 3
"""√S of each, rad."""
COMPASS_HEADING = 6
"""Yaw that the gyros feel, rad, 0 … 2π; 0 unless the vehicle waits for its heading."""
COMPASS_SIGMA = 7
"""Its 1 σ, rad; π before anything is known."""
COMPASS_TIME = 8
"""Time at rest that it comes from, s."""
ATTITUDE_FLOATS = 9
# … and its int64 part
TIME = 0
"""Validity of the last record with an angle, board clock, ns."""
MASK = 1
"""Bit k: angle k of it was used."""
YAW_SOURCE = 2
"""Where the yaw of the beginning came from: reference_layout.YAW_SOURCE_NAMES."""
USED = 3
REFUSED = 4
FLIPPED = 5
WRONG_LENGTH = 6
MISSING = 7
LAST_USED = 8
"""Validity of the last heading used, board clock, ns; far in the past before the first."""
ATTITUDE_INTEGERS = 9


@kernel("void(float32[::1], int64[::1], float32[::1], int64[::1])")
def attitude_report(f, i, floats, integers):
    """Fill a report (places above); only boards with an attitude reference may call it."""
    for k in range(THREE):
        floats[INNOVATION + k] = f[ref.INNOVATION + k]
        floats[SIGMA + k] = f[ref.INNOVATION_SIGMA + k]
    waiting = i[at.MODE] == fl.WAITING_FOR_HEADING and f[ref.COMPASS_SECONDS] > ZERO
    floats[COMPASS_HEADING] = wrap_heading(compass_turn(f)) if waiting else ZERO
    floats[COMPASS_SIGMA] = np.float32(math.sqrt(compass_variance(f, i))) if waiting else PI
    floats[COMPASS_TIME] = f[ref.COMPASS_SECONDS]
    for k in range(np.int32(ATTITUDE_INTEGERS)):
        integers[k] = i[ref.TIME + k]
