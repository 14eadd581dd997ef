"""A filter begins with a state that is given, and with what is known of it."""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.beginning import clear_parameters, enter_navigation
from firmware.nav.covariance import clear
from firmware.nav.earth import refresh_earth
from firmware.nav.gyro_free.states import X_COMPASS_ERROR
from firmware.nav.strapdown import set_attitude
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import quaternion_of_euler

ZERO = np.float32(0.0)
THREE = np.int32(3)
HEIGHT = 0
VELOCITY = 1
ANGLES = 4
"""Yaw, pitch, roll."""
VARIANCES = 7
"""Of position, velocity, tilt, yaw, rate bias, force bias, compass tilt, compass heading."""
SIZE = 15


@kernel("void(float32[::1], int64[::1], int64, int64, int64, float32[::1])")
def begin_filter(f, i, t_ns, latitude, longitude, s):
    """Navigate from now on: place in 2⁻⁴⁰ rad, the rest and the variances in `s` (places above)."""
    i[at.TIME] = t_ns
    i[at.GOOD_SAMPLE_TIME] = t_ns
    i[at.HAVE_SAMPLE] = 0
    i[at.LATITUDE] = latitude
    i[at.LONGITUDE] = longitude
    f[at.HEIGHT] = s[HEIGHT]
    f[at.HEIGHT_REST] = ZERO
    for k in range(THREE):
        f[at.VELOCITY + k] = s[VELOCITY + k]
    w, x, y, z = quaternion_of_euler(s[ANGLES], s[ANGLES + 1], s[ANGLES + 2])
    set_attitude(f, w, x, y, z)
    refresh_earth(f, i)
    clear_parameters(f)
    clear(f)
    v = VARIANCES
    for k in range(THREE):
        f[at.D + at.X_POSITION + k] = s[v]
        f[at.D + at.X_VELOCITY + k] = s[v + 1]
        f[at.D + at.X_ATTITUDE + k] = s[v + 3] if k == 2 else s[v + 2]
        f[at.D + at.X_GYRO_BIAS + k] = s[v + 4]
        f[at.D + at.X_ACCEL_BIAS + k] = s[v + 5]
        if f[cfg.POSITION_ERROR_VARIANCE_H] > ZERO:
            f[at.D + X_COMPASS_ERROR + k] = s[v + 7] if k == 2 else s[v + 6]
    enter_navigation(f, i)
