"""From alignment to navigation: the state at the moment when yaw and a fix are known.

Two ways lead here: after a rest (tilt and gyro bias learnt at rest, yaw from the course or given) and in
motion (everything from a few seconds of motion). Both leave the history with the state at the epoch
looked up.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.earth import refresh_earth
from firmware.nav.flags import NAVIGATING
from firmware.nav.gnss_measurement import epoch_velocity, lever_arm_velocity
from firmware.nav.gnss_scatter import forget_scatter
from firmware.nav.history import clear_history, remember, seconds_between
from firmware.nav.prediction import begin_interval
from firmware.nav.strapdown import move
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
HALF = np.float32(0.5)


@kernel
def set_velocity_and_position(f, i, e, time, dn, de, dd):
    """Take the fix of epoch `e`, valid at `time`; the velocity has changed by (dn, de, dd) since.

    The attitude must be set, and that at the epoch stand in layout.AGO. Returns the age of the epoch in s.
    """
    i[at.LATITUDE] = i[at.FIX_LATITUDE]
    i[at.LONGITUDE] = i[at.FIX_LONGITUDE]
    f[at.HEIGHT] = f[at.GNSS_FIX]
    f[at.HEIGHT_REST] = ZERO
    refresh_earth(f, i)
    north, east, down = epoch_velocity(e)
    wx, wy, wz = lever_arm_velocity(f)
    f[at.VELOCITY] = north - wx + dn
    f[at.VELOCITY + 1] = east - wy + de
    f[at.VELOCITY + 2] = down - wz + dd
    dt = seconds_between(time, i[at.TIME])
    lx = f[cfg.ANTENNA]
    ly = f[cfg.ANTENNA + 1]
    lz = f[cfg.ANTENNA + 2]
    c = at.C_N_B
    move(
        f,
        i,
        (f[at.VELOCITY] - HALF * dn) * dt - (f[c] * lx + f[c + 1] * ly + f[c + 2] * lz),
        (f[at.VELOCITY + 1] - HALF * de) * dt - (f[c + 3] * lx + f[c + 4] * ly + f[c + 5] * lz),
        (f[at.VELOCITY + 2] - HALF * dd) * dt - (f[c + 6] * lx + f[c + 7] * ly + f[c + 8] * lz),
    )
    return dt


@kernel
def clear_parameters(f):
    """No bias, no mounting angle, no latency known."""
    for k in range(np.int32(at.PARAMETERS)):
        f[at.GYRO_BIAS + k] = ZERO


@kernel
def enter_navigation(f, i):
    """All is set: forget the past and navigate."""
    i[at.MODE] = NAVIGATING
    i[at.POSITION_REFUSED_SINCE] = at.NEVER
    i[at.VELOCITY_REFUSED_SINCE] = at.NEVER
    i[at.HEADING_WRONG_SINCE] = at.NEVER
    i[at.PATIENCE_NS] = i[cfg.REJOIN_AFTER_NS]
    forget_scatter(f, i)
    i[at.CONSTRAINT_DUE] = i[at.TIME]
    i[at.CHECK_DUE] = i[at.TIME]
    f[at.PARAMETER_TIME] = ZERO
    for k in range(np.int32(4)):
        f[at.SIDE_SPEED + k] = ZERO
    f[at.AT_REST] = ZERO
    begin_interval(f)
    clear_history(i)
    remember(f, i)
