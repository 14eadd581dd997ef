"""The temperature of the inertial sensor: the gyro bias moves along with it.

    b_g(T) = b_g(T₀) + k (T − T₀)

k, one coefficient an axis, is a state of the filter; the bias is brought to the present temperature once a
second (prediction). A reading counts when it agrees with the one before: a wrong one, as from a disturbed
bus, would move the bias. Without any reading the bias only walks.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.numerics.dialect import kernel

NO_TEMPERATURE = np.float32(at.NO_TEMPERATURE)


@kernel("void(float32[::1], int64[::1], float32)")
def temperature_step(f, i, celsius):
    """Take a reading of the chip's temperature, about once a second."""
    agrees = abs(celsius - f[at.TOLD_TEMPERATURE]) <= f[cfg.TEMPERATURE_STEP]
    f[at.TOLD_TEMPERATURE] = celsius
    if not agrees:
        return
    if f[at.TEMPERATURE] == NO_TEMPERATURE:  # all that was learnt so far belongs to the first one
        f[at.BIAS_TEMPERATURE] = celsius
        f[at.REST_TEMPERATURE] = celsius
        f[at.LEVEL_SUM + 6] = celsius * np.float32(np.int32(i[at.LEVEL_WINDOWS]))
    f[at.TEMPERATURE] = celsius
