"""Can this sample be a measurement? Finite, within the sensor's range, and not frozen while the vehicle
moves.

A frozen sensor at rest is noted but used: rest looks the same. So is one that repeated itself before it ever
moved, until GNSS contradicts: it has no noise. What is refused counts as dead time.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.flags import IMU_NOT_FINITE, IMU_SATURATED, IMU_STUCK, NAVIGATING, report
from firmware.numerics.dialect import kernel

ONE = np.float32(1.0)
HUGE = np.float32(1.0e9)


@kernel
def is_plausible(f, i, wx, wy, wz, ax, ay, az):
    """Judge one sample, in sensor axes as it came; events tell what was wrong."""
    if not abs(wx) + abs(wy) + abs(wz) + abs(ax) + abs(ay) + abs(az) < HUGE:
        report(i, IMU_NOT_FINITE)
        return False
    rate = max(max(abs(wx), abs(wy)), abs(wz))
    force = max(max(abs(ax), abs(ay)), abs(az))
    if rate > f[cfg.RATE_LIMIT] or force > f[cfg.ACCEL_LIMIT]:
        report(i, IMU_SATURATED)
        return False
    r = at.RAW
    same = wx == f[r] and wy == f[r + 1] and wz == f[r + 2]
    if same and ax == f[r + 3] and ay == f[r + 4] and az == f[r + 5]:
        i[at.UNCHANGED] += 1
        if i[at.UNCHANGED] >= i[cfg.STUCK_SAMPLES]:
            report(i, IMU_STUCK)
            return _may_repeat(f, i)
        return True
    i[at.UNCHANGED] = 0
    f[r] = wx
    f[r + 1] = wy
    f[r + 2] = wz
    f[r + 3] = ax
    f[r + 4] = ay
    f[r + 5] = az
    return True


@kernel
def _may_repeat(f, i):
    """Whether readings that do not change may be true ones."""
    if i[at.MODE] != NAVIGATING:
        i[at.SENSOR_REPEATS] = 1
        return True
    contradicted = i[at.VELOCITY_REFUSED_SINCE] != at.NEVER
    return (i[at.SENSOR_REPEATS] != 0 and not contradicted) or not _is_moving(f, i)


@kernel
def _is_moving(f, i):
    """More than 1 m/s, by a fresh fix or by the state."""
    g = at.GNSS_SPEED
    if i[at.TIME] - i[at.FIX_TIME] < i[cfg.GNSS_LOST_NS]:
        return f[g] * f[g] + f[g + 1] * f[g + 1] + f[g + 2] * f[g + 2] > ONE
    v = at.VELOCITY
    return i[at.MODE] == NAVIGATING and f[v] * f[v] + f[v + 1] * f[v + 1] > ONE
