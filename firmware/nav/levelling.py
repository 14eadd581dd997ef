"""Coarse alignment at rest: roll and pitch from the mean specific force, gyro bias from the mean rate.

    f_b = C_b_n (0, 0, −g):   roll = atan2(−f_y, −f_z)    pitch = atan2(f_x, √(f_y² + f_z²))

Means are taken over quiet windows in a row; a window that is not quiet begins them anew. Yaw is not known
yet: attitude is kept against level axes n' whose yaw is 0 here, on a flat Earth at rest, and is refined with
every further quiet window. The rate at rest holds the Earth's; that part is told apart once yaw is known.

While not levelled, the integrals ∫f dt and ∫ω dt (body axes) stand in the places of velocity and of the
vector part of the quaternion, for the alignment in motion.
"""

import math

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.beginning import clear_parameters
from firmware.nav.earth import stand_on_plane
from firmware.nav.flags import LEVELLING, WAITING_FOR_HEADING
from firmware.nav.history import clear_history, remember
from firmware.nav.standstill import gnss_says_moving
from firmware.nav.strapdown import set_attitude
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import quaternion_of_euler
from firmware.numerics.trigonometry import arc_tangent2

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
THREE = np.int32(3)
SIX = np.int32(6)
SEVEN = np.int32(7)
LARGEST_INTEGRAL = np.float32(2.0e3)
LONGEST_MEAN = np.int64(60)
"""Windows; older ones fade."""


@kernel
def begin_levelling(f, i):
    """Forget attitude; wait for rest or motion."""
    i[at.MODE] = LEVELLING
    i[at.LEVEL_WINDOWS] = 0
    i[at.WINDOW_SAMPLES] = 0
    i[at.START_TIME] = at.NEVER
    _clear_integrals(f, i)


@kernel
def _clear_integrals(f, i):
    for k in range(THREE):
        f[at.VELOCITY + k] = ZERO
    for k in range(np.int32(4)):
        f[at.QUATERNION + k] = ZERO
    f[at.HEIGHT] = ZERO
    f[at.HEIGHT_REST] = ZERO
    clear_history(i)


@kernel
def integrate_samples(f, i, dt, wx, wy, wz, ax, ay, az):
    """∫f dt and ∫ω dt, and their history."""
    f[at.VELOCITY] += ax * dt
    f[at.VELOCITY + 1] += ay * dt
    f[at.VELOCITY + 2] += az * dt
    f[at.QUATERNION + 1] += wx * dt
    f[at.QUATERNION + 2] += wy * dt
    f[at.QUATERNION + 3] += wz * dt
    if not abs(f[at.VELOCITY + 2]) < LARGEST_INTEGRAL:
        _clear_integrals(f, i)
        i[at.START_TIME] = at.NEVER
    remember(f, i)


@kernel
def level_by_window(f, i, quiet):
    """Use the window just closed (layout.WINDOW_MEAN): level when enough of them were quiet."""
    if not (quiet and _is_rest(f, i)):
        i[at.LEVEL_WINDOWS] = 0
        return
    count = i[at.LEVEL_WINDOWS]
    if count == 0:
        for k in range(SEVEN):
            f[at.LEVEL_SUM + k] = ZERO
    if count == LONGEST_MEAN:
        count -= 1
        keep = ONE - ONE / np.float32(np.int32(LONGEST_MEAN))
        for k in range(SEVEN):
            f[at.LEVEL_SUM + k] *= keep
    count += 1
    i[at.LEVEL_WINDOWS] = count
    for k in range(SIX):
        f[at.LEVEL_SUM + k] += f[at.WINDOW_MEAN + k]
    f[at.LEVEL_SUM + 6] += f[at.TEMPERATURE]
    if count >= i[cfg.LEVEL_WINDOWS]:
        _level(f, i, np.float32(np.int32(count)))


@kernel
def _is_rest(f, i):
    """A mean rate like a bias, a mean force like gravity, and no fix that says otherwise."""
    m = at.WINDOW_MEAN
    rate = f[m] * f[m] + f[m + 1] * f[m + 1] + f[m + 2] * f[m + 2]
    force = np.float32(math.sqrt(f[m + 3] * f[m + 3] + f[m + 4] * f[m + 4] + f[m + 5] * f[m + 5]))
    return (
        rate < f[cfg.MAX_REST_RATE_SQUARE]
        and abs(force - f[cfg.STANDARD_GRAVITY]) < f[cfg.MAX_REST_FORCE_ERROR]
        and not gnss_says_moving(f, i)
    )


@kernel
def _level(f, i, count):
    clear_parameters(f)
    for k in range(THREE):
        rate = f[at.LEVEL_SUM + k] / count
        f[at.GYRO_BIAS + k] = rate
        f[at.REST_RATE + k] = rate
        f[at.VELOCITY + k] = ZERO
    x = f[at.LEVEL_SUM + 3] / count
    y = f[at.LEVEL_SUM + 4] / count
    z = f[at.LEVEL_SUM + 5] / count
    side = np.float32(math.sqrt(y * y + z * z))
    w, qx, qy, qz = quaternion_of_euler(ZERO, arc_tangent2(x, side), arc_tangent2(-y, -z))
    set_attitude(f, w, qx, qy, qz)
    for k in range(np.int32(4)):
        f[at.REST_QUATERNION + k] = f[at.QUATERNION + k]
    f[at.REST_TIME] = count * f[cfg.WINDOW]
    f[at.REST_TEMPERATURE] = f[at.LEVEL_SUM + 6] / count
    stand_on_plane(f, np.float32(math.sqrt(x * x + side * side)))
    i[at.LEVELLED_AT] = i[at.TIME]
    i[at.MODE] = WAITING_FOR_HEADING
    # it was so for the whole window: epochs valid within it find this state
    now = i[at.TIME]
    clear_history(i)
    i[at.TIME] = now - i[cfg.WINDOW_NS]
    remember(f, i)
    i[at.TIME] = now
    remember(f, i)
