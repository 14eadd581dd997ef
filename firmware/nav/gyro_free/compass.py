"""A compass measures attitude, with an error of its own that lasts.

    φ_m = vector of 2 q_compass ⊗ q_nb*  = φ + e + white,    e: the states of the compass error

so that H = [0 0 I 0 0 | I], the document's [I 0 −I] with the error counted the other way round. The three
rows pass one χ² gate. Headings are first freed of the deviation that the calibration found (calibration) and
turned to true north.
"""

import math

import numpy as np

from firmware.nav import layout as at
from firmware.nav.feedback import clear_correction, feed_back
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.states import COMPASS_ERROR, X_COMPASS_ERROR
from firmware.nav.history import correct_past, look_up
from firmware.nav.measurement import absorb_group, clear_rows, weigh_group
from firmware.nav.prediction import predict
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import quaternion_of_euler, quaternion_product, wrap_heading
from firmware.numerics.trigonometry import sine_cosine

ONE = np.float32(1.0)
TWO = np.float32(2.0)
ZERO = np.float32(0.0)
THREE = np.int32(3)


@kernel
def true_heading(g, heading):
    """Of what the compass shows, rad: less its deviation, plus the declination."""
    s, c = sine_cosine(heading)
    d = gl.COMPASS_DEVIATION
    deviation = g[d] + g[d + 1] * s + g[d + 2] * c + g[d + 3] * (TWO * s * c) + g[d + 4] * (c * c - s * s)
    return wrap_heading(heading - deviation + g[gl.DECLINATION])


@kernel
def compass_update(f, i, g, yaw, pitch, roll, time):
    """Correct `f`, `i` by an attitude (rad, true north) valid at `time`; whether it was believed."""
    predict(f)
    if not look_up(f, i, time):
        return False
    correct_past(f, i, time)
    clear_correction(f)
    clear_rows(f)
    _rows(f, yaw, pitch, roll)
    for k in range(THREE):
        f[at.VARIANCE + k] = g[gl.COMPASS_VARIANCE + k]
    if not weigh_group(f, 0, 3) <= g[gl.GATE_3]:
        return False
    absorb_group(f, 0, 3)
    feed_back(f, i)
    return True


@kernel
def _rows(f, yaw, pitch, roll):
    w, x, y, z = quaternion_of_euler(yaw, pitch, roll)
    q = at.AGO_QUATERNION
    w, x, y, z = quaternion_product(w, x, y, z, f[q], -f[q + 1], -f[q + 2], -f[q + 3])
    twice = TWO * np.float32(math.copysign(ONE, w))
    f[at.RESIDUAL] = twice * x - f[COMPASS_ERROR]
    f[at.RESIDUAL + 1] = twice * y - f[COMPASS_ERROR + 1]
    f[at.RESIDUAL + 2] = twice * z - f[COMPASS_ERROR + 2]
    for k in range(THREE):
        row = at.ROWS + k * at.STATES
        f[row + at.X_ATTITUDE + k] = ONE
        if f[at.D + X_COMPASS_ERROR + k] > ZERO:
            f[row + X_COMPASS_ERROR + k] = ONE
