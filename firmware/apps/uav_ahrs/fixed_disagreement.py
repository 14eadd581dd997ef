"""Whether gyros, force and field tell the same motion, in integers: see `disagreement`.

The mean is one of vec(q_before* ⊗ q_after) in Q30, with MORE bits behind. No float occurs.
"""

import math
from typing import Final

import numpy as np

from firmware.apps.uav_ahrs.fixed_holding import MORE, follow
from firmware.apps.uav_ahrs.holding import CORRECTION
from firmware.nav.attitude.fixed import layout as at
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed.arithmetic import rounded_shift

Q: Final = 30
RAD_PER_S: Final = math.ldexp(2.0 / 0.008, -(Q + MORE))
"""Of a count of the mean."""


@kernel
def follow_correction(s, g, regaining, w, x, y, z):
    """As `disagreement.follow_correction`."""
    q = at.QUATERNION
    aw, ax, ay, az = np.int64(s[q]), np.int64(s[q + 1]), np.int64(s[q + 2]), np.int64(s[q + 3])
    c = CORRECTION
    follow(g, c, rounded_shift(w * ax - x * aw - y * az + z * ay, Q))
    follow(g, c + 1, rounded_shift(w * ay + x * az - y * aw - z * ax, Q))
    follow(g, c + 2, rounded_shift(w * az - x * ay + y * ax - z * aw, Q))
    if regaining:
        for n in range(np.int32(3)):
            g[c + n] = np.int64(0)
