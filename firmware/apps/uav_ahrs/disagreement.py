"""Whether gyros on one side, force and field on the other tell the same motion.

What the drift compensation turns the attitude by is small as long as they do: gyros are known to some
hundredths of a degree a second. So the mean rate of its corrections, over TAU,

    c = mean of 2 vec(q_before* ⊗ q_after) / T,        rad/s, body axes

says by how much rates are wrong, or force and field are. It is kept in three places of the memory of
`holding`, and told from `LIMIT` on. While the attitude is being regained anyway it says nothing.
"""

import math
from typing import Final

import numpy as np

from firmware.apps.uav_ahrs.holding import CORRECTION, TAU
from firmware.nav.attitude import layout as at
from firmware.numerics.dialect import kernel

LIMIT: Final = math.radians(2.0)
"""rad/s, magnitude."""
ZERO = np.float32(0.0)
TWO = np.float32(2.0)


@kernel
def follow_correction(s, g, regaining, w, x, y, z):
    """Let the mean go on by the correction that made QUATERNION of (w, x, y, z)."""
    q = at.QUATERNION
    aw, ax, ay, az = s[q], s[q + 1], s[q + 2], s[q + 3]
    share = s[at.PERIOD] / TAU
    rate = TWO / s[at.PERIOD]
    c = CORRECTION
    g[c] += share * (rate * (w * ax - x * aw - y * az + z * ay) - g[c])
    g[c + 1] += share * (rate * (w * ay + x * az - y * aw - z * ax) - g[c + 1])
    g[c + 2] += share * (rate * (w * az - x * ay + y * ax - z * aw) - g[c + 2])
    if regaining:
        for n in range(np.int32(3)):
            g[c + n] = ZERO
