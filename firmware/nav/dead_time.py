"""Time without a plausible inertial sample: position goes on by velocity, and the covariance knows.

What attitude and velocity did meanwhile is unknown up to rates of tilt and yaw and an acceleration
(`lost_tilt_rate`, `lost_yaw_rate`, `lost_force`), constant over the dead time T: their standard
deviations grow
with T, so the variances of an interval are the differences of σ² T². A GNSS epoch that was valid before
the end
of dead time is compared with a state that knew no better: its variances grow by the same. After too long,
attitude is lost and alignment begins anew.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.flags import IMU_GAP, report
from firmware.nav.history import remember, seconds_between
from firmware.nav.strapdown import move
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
QUARTER = np.float32(0.25)
LONGEST = np.float32(100.0)


@kernel
def lose(f, i, before, after):
    """Dead time from `before` to `after` (s since it began) up to now: the noise of the interval grows."""
    i[at.DEAD_UNTIL] = i[at.TIME]
    after = min(after, LONGEST)
    before = min(before, LONGEST)
    a = after * after
    b = before * before
    f[at.LOST_TILT] += f[cfg.LOST_TILT_RATE_SQUARE] * (a - b)
    f[at.LOST_YAW] += f[cfg.LOST_YAW_RATE_SQUARE] * (a - b)
    f[at.LOST_VELOCITY] += f[cfg.LOST_FORCE_SQUARE] * (a - b)
    f[at.LOST_POSITION] += QUARTER * f[cfg.LOST_FORCE_SQUARE] * (a * a - b * b)


@kernel
def coast(f, i, t_ns):
    """Carry the position to `t_ns` by the velocity; the samples since then were no good."""
    before = seconds_between(i[at.GOOD_SAMPLE_TIME], i[at.TIME])
    dt = seconds_between(i[at.TIME], t_ns)
    if dt > ZERO:
        move(f, i, f[at.VELOCITY] * dt, f[at.VELOCITY + 1] * dt, f[at.VELOCITY + 2] * dt)
        i[at.TIME] = t_ns
        lose(f, i, before, before + dt)
        f[at.SINCE_TIME] += dt
        remember(f, i)
    i[at.HAVE_SAMPLE] = 0
    report(i, IMU_GAP)


@kernel
def lost_since(f, i, time):
    """Variances of velocity and position, against now, of a state at `time` before the end of dead time."""
    if i[at.DEAD_UNTIL] <= time:
        return ZERO, ZERO
    dt = seconds_between(time, i[at.TIME])
    square = f[cfg.LOST_FORCE_SQUARE] * dt * dt
    return square, QUARTER * square * dt * dt


@kernel
def lost_turn_since(f, i, time):
    """Variances of tilt and yaw, against now, of a state at `time` before the end of dead time."""
    if i[at.DEAD_UNTIL] <= time:
        return ZERO, ZERO
    dt = seconds_between(time, i[at.TIME])
    return f[cfg.LOST_TILT_RATE_SQUARE] * dt * dt, f[cfg.LOST_YAW_RATE_SQUARE] * dt * dt
