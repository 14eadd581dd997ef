"""Alignment at rest: tilt from gravity, heading from the compass, and the arms' accelerometers made equal.

At rest the nine accelerometers read gravity along three axes: A1, A4, A7 along x, A2, A5, A8 along y, A3, A6,
A9 along z. What the means of the six on the arms differ by from those at the origin is their offset: taken
off, ω̇ and the products are zero at rest. Tilt has the error of the origin's own biases, b / g.
"""

import math

import numpy as np

from firmware.nav.gyro_free import layout as at
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.compass import true_heading
from firmware.nav.gyro_free.packet import signed
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import wrap_heading
from firmware.numerics.trigonometry import arc_tangent2, sine_cosine

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
RADIANS_PER_TENTH = np.float32(1.7453292519943295e-3)
SIX = np.int32(6)
NINE = np.int32(9)
THREE = np.int32(3)

MEANS = 0
"""Places in the array of sums: A1 … A9, then sine and cosine of the heading, samples, readings."""
SINE = 9
COSINE = 10
SAMPLES = 11
READINGS = 12
SIZE = 13
YAW, PITCH, ROLL = 0, 1, 2


@kernel("void(float32[::1], int64[::1], float32[::1])")
def gather_rest(g, words, sums):
    """One packet at rest: running means of all in `sums` (zeros at first)."""
    if words[pk.FAULTS] == 0:
        sums[SAMPLES] += ONE
        for k in range(NINE):
            count = np.float32(np.int32(signed(words[pk.ACCELERATIONS + k])))
            value = count * g[at.SCALE + k] - g[at.OFFSET + k]
            sums[MEANS + k] += (value - sums[MEANS + k]) / sums[SAMPLES]
    if words[pk.FLAGS] & pk.HAS_COMPASS:
        sums[READINGS] += ONE
        heading = np.float32(np.int32(words[pk.HEADING])) * RADIANS_PER_TENTH
        s, c = sine_cosine(true_heading(g, heading))
        sums[SINE] += (s - sums[SINE]) / sums[READINGS]
        sums[COSINE] += (c - sums[COSINE]) / sums[READINGS]


@kernel("boolean(float32[::1], int64[::1], float32[::1], float32[::1])")
def finish_alignment(g, n, sums, angles):
    """Offsets of the arms to `g`, rates to zero, yaw, pitch and roll (rad) to `angles`; False: nothing was
    gathered, nothing changed."""
    if sums[SAMPLES] < ONE or sums[READINGS] < ONE:
        return False
    for k in range(SIX):
        origin = 6 + (k if k < 3 else k - 3)
        g[at.OFFSET + k] += sums[MEANS + k] - sums[MEANS + origin]
    for k in range(THREE):
        g[at.METHOD_RATE + k] = ZERO
        g[at.INTEGRAL + k] = ZERO
        g[at.INTEGRAL_REST + k] = ZERO
        g[at.FUSED + k] = ZERO
        g[at.FUSED_REST + k] = ZERO
    n[at.HAVE_SAMPLE] = 0
    x, y, z = sums[MEANS + 6], sums[MEANS + 7], sums[MEANS + 8]
    angles[YAW] = wrap_heading(arc_tangent2(sums[SINE], sums[COSINE]))
    angles[PITCH] = arc_tangent2(x, np.float32(math.sqrt(y * y + z * z)))
    angles[ROLL] = arc_tangent2(-y, -z)
    return True
