"""How much a receiver's position really scatters from one epoch to the next: some smooth it to a centimetre.

What an update leaves of the residual of an epoch is error that lasts; what the residual of the next differs
by, w, is white. Its variance, half the mean square of w, is a mean over some thirty epochs. Four times that
replaces the configured white noise where it is less, and the walk of the position goes with it, so that the
same time is averaged over. A receiver that scatters as configured changes nothing (Mehra, Approaches to
adaptive filtering, IEEE Trans. Automatic Control 17 (1972)).
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.covariance import remaining_residual
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
QUARTER = np.float32(0.25)
ONE = np.float32(1.0)
FOUR = np.float32(4.0)
FEW = np.float32(10.0)
"""Epochs that do not prove anything yet."""
MEMORY = np.float32(30.0)


@kernel
def forget_scatter(f, i):
    """The receiver scatters as configured, for all that is known."""
    f[at.SCATTER_COUNT] = ZERO
    f[at.SCATTER_SHARE] = ONE
    i[at.SCATTER_TIME] = at.NEVER


@kernel
def learn_scatter(f, i, time):
    """Compare the horizontal residuals of the epoch valid at `time` with what was left of the one before."""
    if time - i[at.SCATTER_TIME] < i[cfg.GNSS_LOST_NS]:
        north = f[at.RESIDUAL] - f[at.LEFT_RESIDUAL]
        east = f[at.RESIDUAL + 1] - f[at.LEFT_RESIDUAL + 1]
        f[at.SCATTER_COUNT] = min(f[at.SCATTER_COUNT] + ONE, MEMORY)
        difference = QUARTER * (north * north + east * east) - f[at.SCATTER]
        f[at.SCATTER] += difference / f[at.SCATTER_COUNT]
        if f[at.SCATTER_COUNT] > FEW:
            f[at.SCATTER_SHARE] = min(FOUR * f[at.SCATTER] / f[cfg.POSITION_VARIANCE], ONE)
    i[at.SCATTER_TIME] = at.NEVER


@kernel
def keep_residual(f, i, time):
    """The position was absorbed: what is left of its residuals serves the next epoch."""
    f[at.LEFT_RESIDUAL] = remaining_residual(f, 0)
    f[at.LEFT_RESIDUAL + 1] = remaining_residual(f, 1)
    i[at.SCATTER_TIME] = time
