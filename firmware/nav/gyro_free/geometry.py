"""Nine accelerometers on six arms and at the origin: what they say about rotation and force.

A point at u (body axes, from the origin) feels  a = A + ω̇ × u + ω × (ω × u). With arms of length l:

    A1 x at (0, l, 0)     A2 y at (0, 0, l)     A3 z at (l, 0, 0)      A7 x, A8 y, A9 z at the origin
    A4 x at (0, 0, −l)    A5 y at (−l, 0, 0)    A6 z at (0, −l, 0)

    ω̇_x = (A8 + A9 − A2 − A6) / 2l        ω_x ω_y = (A1 + A8 − A5 − A7) / 2l
    ω̇_y = (A7 + A9 − A3 − A4) / 2l        ω_y ω_z = (A2 + A9 − A6 − A8) / 2l
    ω̇_z = (A7 + A8 − A1 − A5) / 2l        ω_x ω_z = (A3 + A7 − A4 − A9) / 2l

(the document's 2.12 and 2.13; specific force is A7, A8, A9, 2.11). The squares of ω do not show: each
accelerometer is directed across its arm. White noise σ of every accelerometer makes σ/l in each of the six.
"""

import numpy as np

from firmware.nav.gyro_free import layout as at
from firmware.numerics.dialect import kernel

POSITIONS = (
    (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0),
    (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0),
    (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0),
)  # fmt: skip
"""Of A1 … A9 in arm lengths."""
DIRECTIONS = (0, 1, 2, 0, 1, 2, 0, 1, 2)
"""The body axis that A1 … A9 feel."""
THREE = np.int32(3)


@kernel
def resolve_rotation(g):
    """layout.ACCELERATION to ω̇ and products; those of the samples before are kept."""
    for k in range(THREE):
        g[at.ANGULAR_ACCELERATION_TWO_BEFORE + k] = g[at.ANGULAR_ACCELERATION_BEFORE + k]
        g[at.ANGULAR_ACCELERATION_BEFORE + k] = g[at.ANGULAR_ACCELERATION + k]
        g[at.PRODUCTS_BEFORE + k] = g[at.PRODUCTS + k]
    a1 = g[at.ACCELERATION]
    a2 = g[at.ACCELERATION + 1]
    a3 = g[at.ACCELERATION + 2]
    a4 = g[at.ACCELERATION + 3]
    a5 = g[at.ACCELERATION + 4]
    a6 = g[at.ACCELERATION + 5]
    a7 = g[at.ACCELERATION + 6]
    a8 = g[at.ACCELERATION + 7]
    a9 = g[at.ACCELERATION + 8]
    p = g[at.PER_TWO_ARMS]
    g[at.ANGULAR_ACCELERATION] = ((a8 - a2) + (a9 - a6)) * p
    g[at.ANGULAR_ACCELERATION + 1] = ((a7 - a4) + (a9 - a3)) * p
    g[at.ANGULAR_ACCELERATION + 2] = ((a7 - a1) + (a8 - a5)) * p
    g[at.PRODUCTS] = ((a1 - a7) + (a8 - a5)) * p
    g[at.PRODUCTS + 1] = ((a2 - a8) + (a9 - a6)) * p
    g[at.PRODUCTS + 2] = ((a3 - a9) + (a7 - a4)) * p
