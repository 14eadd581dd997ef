"""Out of numbers that are none: begin again from the last state that was sound."""

import numpy as np

from firmware.nav import layout as at
from firmware.nav.covariance import clear
from firmware.nav.flags import NUMERIC_RESTART, report
from firmware.nav.levelling import begin_levelling
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
LARGEST = np.float32(1.0e7)
N = np.int32(at.STATES)


@kernel
def state_is_sound(f):
    """Whether velocity, attitude and height are finite (NaN and infinity spoil the sum)."""
    total = abs(f[at.HEIGHT])
    for k in range(np.int32(3)):
        total += abs(f[at.VELOCITY + k])
    for k in range(np.int32(4)):
        total += abs(f[at.QUATERNION + k])
    return total < LARGEST


@kernel
def keep_good_state(f, i):
    """Note the present place as sound."""
    i[at.GOOD_TIME] = i[at.TIME]
    i[at.GOOD_LATITUDE] = i[at.LATITUDE]
    i[at.GOOD_LONGITUDE] = i[at.LONGITUDE]
    f[at.GOOD_HEIGHT] = f[at.HEIGHT]


@kernel
def restart(f, i):
    """Alignment from the beginning, at the last sound place; nothing of what was estimated is kept."""
    report(i, NUMERIC_RESTART)
    clear(f)
    for k in range(np.int32(at.PARAMETERS)):
        f[at.GYRO_BIAS + k] = ZERO
    for k in range(np.int32(3)):
        f[at.OMEGA_B + k] = ZERO
        f[at.FORCE_B + k] = ZERO
        f[at.DELTA_ANGLE + k] = ZERO
        f[at.DELTA_VELOCITY + k] = ZERO
        f[at.GNSS_SPEED + k] = ZERO
    i[at.LATITUDE] = i[at.GOOD_LATITUDE]
    i[at.LONGITUDE] = i[at.GOOD_LONGITUDE]
    i[at.HAVE_SAMPLE] = 0
    begin_levelling(f, i)
