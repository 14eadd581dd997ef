"""Is the vehicle at rest? Quiet sensors over a window of one second, and nothing that says it moves.

Quiet alone is not rest: a car that rolls or brakes evenly is as quiet. The state must not have moved,
turned or changed its velocity over the window. While GNSS is fresh its low-passed velocity must be near
zero; without it, the stretch of quiet windows must not have begun in motion, and zero must be plausible to
the filter itself (the gate of the update). The window starts anew each second, so that an update tells what
was so for the whole second before it. Sums are of differences to the window's first sample: float32 keeps
its digits.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.feedback import clear_correction, correction_is_sound, feed_back
from firmware.nav.flags import STANDSTILL, report
from firmware.nav.measurement import absorb_group, clear_rows, weigh_group
from firmware.nav.prediction import predict
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
THREE = np.int32(3)
SIX = np.int32(6)


@kernel
def watch(f, i, dt, wx, wy, wz, ax, ay, az):
    """Add a sample (body axes, biases in it); True when it completes a window (means in WINDOW_MEAN)."""
    if i[at.WINDOW_SAMPLES] == 0:
        f[at.WINDOW_REFERENCE] = wx
        f[at.WINDOW_REFERENCE + 1] = wy
        f[at.WINDOW_REFERENCE + 2] = wz
        f[at.WINDOW_REFERENCE + 3] = ax
        f[at.WINDOW_REFERENCE + 4] = ay
        f[at.WINDOW_REFERENCE + 5] = az
        for k in range(SIX):
            f[at.WINDOW_SUM + k] = ZERO
        for k in range(THREE):
            f[at.WINDOW_VELOCITY + k] = f[at.VELOCITY + k]
        f[at.WINDOW_SQUARES] = ZERO
        f[at.WINDOW_SQUARES + 1] = ZERO
        f[at.WINDOW_TIME] = ZERO
    i[at.WINDOW_SAMPLES] += 1
    wx -= f[at.WINDOW_REFERENCE]
    wy -= f[at.WINDOW_REFERENCE + 1]
    wz -= f[at.WINDOW_REFERENCE + 2]
    ax -= f[at.WINDOW_REFERENCE + 3]
    ay -= f[at.WINDOW_REFERENCE + 4]
    az -= f[at.WINDOW_REFERENCE + 5]
    f[at.WINDOW_SUM] += wx
    f[at.WINDOW_SUM + 1] += wy
    f[at.WINDOW_SUM + 2] += wz
    f[at.WINDOW_SUM + 3] += ax
    f[at.WINDOW_SUM + 4] += ay
    f[at.WINDOW_SUM + 5] += az
    f[at.WINDOW_SQUARES] += wx * wx + wy * wy + wz * wz
    f[at.WINDOW_SQUARES + 1] += ax * ax + ay * ay + az * az
    f[at.WINDOW_TIME] += dt
    return not f[at.WINDOW_TIME] < f[cfg.WINDOW]


@kernel
def close_window(f, i):
    """Means of the window to layout.WINDOW_MEAN; True when it was quiet. A new window begins."""
    per_count = ONE / np.float32(np.int32(i[at.WINDOW_SAMPLES]))
    i[at.WINDOW_SAMPLES] = 0
    rate = f[at.WINDOW_SQUARES] * per_count
    force = f[at.WINDOW_SQUARES + 1] * per_count
    for k in range(SIX):
        mean = f[at.WINDOW_SUM + k] * per_count
        f[at.WINDOW_MEAN + k] = f[at.WINDOW_REFERENCE + k] + mean
        if k < 3:
            rate -= mean * mean
        else:
            force -= mean * mean
    return rate < f[cfg.STILL_RATE_SQUARE] and force < f[cfg.STILL_FORCE_SQUARE]


@kernel
def gnss_says_moving(f, i):
    """Whether a fresh fix has a velocity that rest does not allow."""
    x = f[at.GNSS_SPEED]
    y = f[at.GNSS_SPEED + 1]
    z = f[at.GNSS_SPEED + 2]
    return _gnss_is_fresh(i) and not x * x + y * y + z * z < f[cfg.STILL_SPEED_SQUARE]


@kernel
def _gnss_is_fresh(i):
    return i[at.TIME] - i[at.FIX_TIME] < i[cfg.GNSS_LOST_NS]


@kernel
def was_rest(f, i, quiet):
    """Whether the window just closed was a rest, as far as GNSS knows."""
    if not quiet:
        i[at.QUIET_IS_NO_REST] = 0
        return False
    if _gnss_is_fresh(i):
        i[at.QUIET_IS_NO_REST] = 1 if gnss_says_moving(f, i) else 0
    return i[at.QUIET_IS_NO_REST] == 0


@kernel
def state_is_still(f):
    """Whether the state itself hardly moved, turned or changed its velocity over the window just closed."""
    speed = ZERO
    change = ZERO
    rate = ZERO
    for k in range(THREE):
        v = f[at.VELOCITY + k]
        a = v - f[at.WINDOW_VELOCITY + k]
        w = f[at.WINDOW_MEAN + k] - f[at.GYRO_BIAS + k]
        speed += v * v
        change += a * a
        rate += w * w
    return (
        speed < f[cfg.REST_SPEED_SQUARE]
        and change < f[cfg.STILL_ACCELERATION_SQUARE]
        and rate < f[cfg.STILL_RATE_SQUARE]
    )


@kernel
def rest_updates(f, i):
    """Zero velocity and zero rate over the window just closed, if that is plausible."""
    predict(f)
    clear_correction(f)
    clear_rows(f)
    for k in range(THREE):
        f[at.ROWS + k * at.STATES + at.X_VELOCITY + k] = ONE
        f[at.RESIDUAL + k] = -f[at.VELOCITY + k]
        f[at.VARIANCE + k] = f[cfg.ZERO_VELOCITY_VARIANCE]
    if not weigh_group(f, 0, 3) <= f[cfg.GATE_3]:
        return
    absorb_group(f, 0, 3)
    c = at.C_N_B
    north = f[at.EARTH_RATE_N]
    down = f[at.EARTH_RATE_D]
    for k in range(THREE):
        row = 3 + k
        f[at.ROWS + row * at.STATES + at.X_GYRO_BIAS + k] = ONE
        f[at.ROWS + row * at.STATES + at.X_GYRO_INSTABILITY + k] = ONE
        earth = f[c + k] * north + f[c + 6 + k] * down
        f[at.RESIDUAL + row] = (
            f[at.WINDOW_MEAN + k] - f[at.GYRO_BIAS + k] - f[at.GYRO_INSTABILITY + k] - earth
        )
        f[at.VARIANCE + row] = f[cfg.ZERO_RATE_VARIANCE]
        if f[cfg.EARTH_ERRORS] != ZERO:
            # C_n_bᵀ (ω_ie × φ)
            h = at.ROWS + row * at.STATES + at.X_ATTITUDE
            f[h] = f[c + 3 + k] * down
            f[h + 1] = f[c + 6 + k] * north - f[c + k] * down
            f[h + 2] = -f[c + 3 + k] * north
    if weigh_group(f, 3, 3) <= f[cfg.GATE_3]:
        absorb_group(f, 3, 3)
    if correction_is_sound(f):
        feed_back(f, i)
        report(i, STANDSTILL)
