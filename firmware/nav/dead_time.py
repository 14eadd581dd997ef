"""Time without a plausible inertial sample: position goes on by velocity, and the covariance knows.

What attitude and velocity did meanwhile is unknown up to a rate and an acceleration (`lost_rate`,
`lost_force`), constant over the dead time T: their standard deviations grow with T, so the variances of an
interval are the differences of σ² T². After too long, attitude is lost and alignment begins anew.
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
def lose(f, before, after):
    """Add to the noise of the interval what dead time from `before` to `after` (s since it began) loses."""
    after = min(after, LONGEST)
    before = min(before, LONGEST)
    a = after * after
    b = before * before
    f[at.LOST_ANGLE] += f[cfg.LOST_RATE_SQUARE] * (a - b)
    f[at.LOST_VELOCITY] += f[cfg.LOST_FORCE_SQUARE] * (a - b)
    f[at.LOST_POSITION] += QUARTER * f[cfg.LOST_FORCE_SQUARE] * (a * a - b * b)


@kernel
def coast(f, i, t_ns):
    """Carry the position to `t_ns` by the velocity; the samples since then were no good."""
    before = seconds_between(i[at.GOOD_SAMPLE_TIME], i[at.TIME])
    dt = seconds_between(i[at.TIME], t_ns)
    if dt > ZERO:
        move(f, i, f[at.VELOCITY] * dt, f[at.VELOCITY + 1] * dt, f[at.VELOCITY + 2] * dt)
        lose(f, before, before + dt)
        f[at.SINCE_TIME] += dt
        i[at.TIME] = t_ns
        remember(f, i)
    i[at.HAVE_SAMPLE] = 0
    report(i, IMU_GAP)
