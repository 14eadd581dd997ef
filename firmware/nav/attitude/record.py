"""The part of a solution that is integers in every arithmetic."""

import numpy as np

from firmware.nav.attitude import layout as at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import nanodegrees_of_units

MICRO = 1_000_000
HALF_UNIT = 1 << 19


@kernel
def write_integers(i, out):
    """Position, mode, flags and counters; what was noticed before is forgotten."""
    out[at.OUT_LATITUDE] = nanodegrees_of_units(i[at.LATITUDE])
    out[at.OUT_LONGITUDE] = nanodegrees_of_units(i[at.LONGITUDE])
    out[at.OUT_HEIGHT] = (i[at.HEIGHT] * MICRO + HALF_UNIT) >> 20
    out[at.OUT_MODE] = i[at.MODE]
    out[at.OUT_FLAGS] = i[at.NOTICED_SINCE]
    out[at.OUT_ITERATIONS] = i[at.ITERATIONS]
    i[at.NOTICED_SINCE] = 0
    saturations = np.int64(0)
    for k in range(np.int32(8)):
        saturations += i[at.SATURATIONS + k]
    out[at.OUT_SATURATIONS] = saturations
