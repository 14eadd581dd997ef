"""Can this sample be a measurement? Finite, within the sensor's range, and not frozen while the vehicle
moves.

One axis alone that repeats itself is refused once GNSS contradicts, and then until it changes.

A frozen sensor at rest is noted but used: rest looks the same. So is one that repeated itself before it ever
moved, until GNSS contradicts: it has no noise. A sensor so fine that its rounding is known (`repeat_rate`)
shows its noise at rest, too, and is refused there as well. What is refused counts as dead time.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.dead_time import lose
from firmware.nav.flags import IMU_NOT_FINITE, IMU_SATURATED, IMU_STUCK, NAVIGATING, report
from firmware.nav.history import seconds_between
from firmware.numerics.dialect import kernel

ONE = np.float32(1.0)
HUGE = np.float32(1.0e9)
ZERO = np.float32(0.0)
FOUND_STUCK = np.float32(1.0e6)
"""In place of a number of repeats: this axis was found stuck."""
AXES = np.int32(6)


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
    rate_toggle = f[cfg.REPEAT_RATE]
    force_toggle = f[cfg.REPEAT_FORCE]
    same = _repeats(wx, f[r], rate_toggle) and _repeats(wy, f[r + 1], rate_toggle)
    same = same and _repeats(wz, f[r + 2], rate_toggle) and _repeats(ax, f[r + 3], force_toggle)
    if same and _repeats(ay, f[r + 4], force_toggle) and _repeats(az, f[r + 5], force_toggle):
        i[at.UNCHANGED] += 1
        if i[at.UNCHANGED] >= i[cfg.STUCK_SAMPLES]:
            report(i, IMU_STUCK)
            if _may_repeat(f, i):
                return True
            _count_repeats_as_dead(f, i)
            return False
        return True
    i[at.UNCHANGED] = 0
    if _is_axis_stuck(f, i, wx, wy, wz, ax, ay, az):
        report(i, IMU_STUCK)
        return False
    f[r] = wx
    f[r + 1] = wy
    f[r + 2] = wz
    f[r + 3] = ax
    f[r + 4] = ay
    f[r + 5] = az
    return True


@kernel
def _repeats(reading, before, toggle):
    """Whether this is the reading before, but for the last digit of a sensor that carries its rounding on."""
    return abs(reading - before) <= toggle


@kernel
def _is_axis_stuck(f, i, wx, wy, wz, ax, ay, az):
    """Count repeats of each axis; whether one of them has stuck while the others went on."""
    r = at.RAW
    n = at.AXIS_REPEATS
    rate_toggle = f[cfg.REPEAT_RATE]
    force_toggle = f[cfg.REPEAT_FORCE]
    f[n] = f[n] + ONE if _repeats(wx, f[r], rate_toggle) else ZERO
    f[n + 1] = f[n + 1] + ONE if _repeats(wy, f[r + 1], rate_toggle) else ZERO
    f[n + 2] = f[n + 2] + ONE if _repeats(wz, f[r + 2], rate_toggle) else ZERO
    f[n + 3] = f[n + 3] + ONE if _repeats(ax, f[r + 3], force_toggle) else ZERO
    f[n + 4] = f[n + 4] + ONE if _repeats(ay, f[r + 4], force_toggle) else ZERO
    f[n + 5] = f[n + 5] + ONE if _repeats(az, f[r + 5], force_toggle) else ZERO
    longest = ZERO
    for k in range(AXES):
        longest = max(longest, f[n + k])
    if longest >= FOUND_STUCK:
        return True
    few = np.int64(np.int32(longest)) < i[cfg.STUCK_SAMPLES]
    if few or i[at.MODE] != NAVIGATING or i[at.VELOCITY_REFUSED_SINCE] == at.NEVER or not _is_moving(f, i):
        return False
    for k in range(AXES):
        if f[n + k] == longest:
            f[n + k] = FOUND_STUCK
    return True


@kernel
def _may_repeat(f, i):
    """Whether readings that do not change may be true ones."""
    if i[at.MODE] != NAVIGATING:
        i[at.SENSOR_REPEATS] = 1
        return True
    contradicted = i[at.VELOCITY_REFUSED_SINCE] != at.NEVER
    if i[at.SENSOR_REPEATS] != 0 and not contradicted:
        return True
    return f[cfg.REPEAT_RATE] == ZERO and not _is_moving(f, i)


@kernel
def _count_repeats_as_dead(f, i):
    """Once, when repeats are found to be false: what was made of them since they began is dead time, too."""
    if i[at.MODE] == NAVIGATING and i[at.GOOD_SAMPLE_TIME] == i[at.TIME]:
        repeats_ns = i[cfg.STUCK_SAMPLES] * i[cfg.PERIOD_NS]
        i[at.GOOD_SAMPLE_TIME] -= repeats_ns
        lose(f, i, ZERO, seconds_between(i[at.GOOD_SAMPLE_TIME], i[at.TIME]))


@kernel
def _is_moving(f, i):
    """More than 1 m/s, by a fresh fix or by the state."""
    g = at.GNSS_SPEED
    if i[at.TIME] - i[at.FIX_TIME] < i[cfg.GNSS_LOST_NS]:
        return f[g] * f[g] + f[g + 1] * f[g + 1] + f[g + 2] * f[g + 2] > ONE
    v = at.VELOCITY
    return i[at.MODE] == NAVIGATING and f[v] * f[v] + f[v + 1] * f[v + 1] > ONE
