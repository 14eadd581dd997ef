"""The door for inertial samples: one sample moves the state to its time.

What follows depends on the mode: while levelling the samples are gathered; levelled, attitude and velocity
run on a flat Earth until yaw is known; navigating, the strapdown runs on the ellipsoid, the covariance
follows
every `covariance_period`, the constraint of the vehicle every `constraint_period`, each window of a second is
asked whether it was a rest, and twice a second all is looked over.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.covariance import is_sound
from firmware.nav.dead_time import coast, lose
from firmware.nav.earth import refresh_earth
from firmware.nav.flags import IMU_GAP, LEVELLING, NAVIGATING, WAITING, report
from firmware.nav.gyrocompass import gather_rest
from firmware.nav.history import remember, seconds_between
from firmware.nav.levelling import begin_levelling, integrate_samples, level_by_window
from firmware.nav.plausibility import is_plausible
from firmware.nav.prediction import leave_rest, predict
from firmware.nav.restart import keep_good_state, restart, state_is_sound
from firmware.nav.standstill import close_window, rest_updates, state_is_still, was_rest, watch
from firmware.nav.strapdown import advance_between_samples, advance_by_mean
from firmware.nav.vehicle import constrain, gather_side_speed
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
QUARTER = np.float32(0.25)
FOUR = np.float32(4.0)
THREE = np.int32(3)


@kernel(
    "void(float32[::1], int64[::1], int64, float32, float32, float32, float32, float32, float32, float32)"
)
def imu_step(f, i, t_ns, dt, wx, wy, wz, ax, ay, az):
    """One sample of time `t_ns` (board clock), `dt` s after the one before: ω rad/s, f m/s², sensor axes.

    Instantaneous values for the two-sample algorithm, means over `dt` otherwise. Never raises: what cannot be
    a measurement is refused, reported as an event, and counts as dead time.
    """
    if i[at.MODE] == WAITING:
        i[at.TIME] = t_ns
        begin_levelling(f, i)
    if not is_plausible(f, i, wx, wy, wz, ax, ay, az):
        if i[at.MODE] == NAVIGATING and t_ns - i[at.TIME] > i[cfg.SILENCE_NS]:
            coast(f, i, t_ns)
        return
    wx -= f[cfg.KNOWN_BIAS]
    wy -= f[cfg.KNOWN_BIAS + 1]
    wz -= f[cfg.KNOWN_BIAS + 2]
    ax -= f[cfg.KNOWN_BIAS + 3]
    ay -= f[cfg.KNOWN_BIAS + 4]
    az -= f[cfg.KNOWN_BIAS + 5]
    m = cfg.C_B_S
    gx = f[m] * wx + f[m + 1] * wy + f[m + 2] * wz
    gy = f[m + 3] * wx + f[m + 4] * wy + f[m + 5] * wz
    gz = f[m + 6] * wx + f[m + 7] * wy + f[m + 8] * wz
    hx = f[m] * ax + f[m + 1] * ay + f[m + 2] * az
    hy = f[m + 3] * ax + f[m + 4] * ay + f[m + 5] * az
    hz = f[m + 6] * ax + f[m + 7] * ay + f[m + 8] * az
    dt = _interval(f, i, t_ns, dt)
    closed = dt > ZERO and watch(f, i, dt, gx, gy, gz, hx, hy, hz)
    if i[at.MODE] == LEVELLING:
        if dt > ZERO:
            integrate_samples(f, i, dt, gx, gy, gz, hx, hy, hz)
    else:
        b = at.GYRO_BIAS
        n = at.GYRO_INSTABILITY
        gx -= f[b] + f[n] + f[at.YAW_RESPONSE] * gz
        gy -= f[b + 1] + f[n + 1] + f[at.YAW_RESPONSE + 1] * gz
        gz -= f[b + 2] + f[n + 2] + f[at.YAW_RESPONSE + 2] * gz
        r = at.FORCE_RESPONSE
        kx = hx
        hx -= f[at.ACCEL_BIAS] + f[r] * kx + f[r + 3] * hy
        hz -= f[at.ACCEL_BIAS + 2] + f[r + 2] * kx + f[r + 5] * hy
        hy -= f[at.ACCEL_BIAS + 1] + f[r + 1] * kx + f[r + 4] * hy
        if dt > ZERO:
            _advance(f, i, dt, gx, gy, gz, hx, hy, hz)
        f[at.OMEGA_B] = gx
        f[at.OMEGA_B + 1] = gy
        f[at.OMEGA_B + 2] = gz
        f[at.FORCE_B] = hx
        f[at.FORCE_B + 1] = hy
        f[at.FORCE_B + 2] = hz
        if dt > ZERO:
            _follow_up(f, i, dt)
    if closed:
        _look_back(f, i, close_window(f, i))


@kernel
def _interval(f, i, t_ns, dt):
    """Length of the interval that this sample ends, s, and the state's time set to it; 0: it only begins
    one."""
    dead = seconds_between(i[at.GOOD_SAMPLE_TIME], t_ns)
    elapsed = seconds_between(i[at.TIME], t_ns)
    if i[at.HAVE_SAMPLE] != 0 and not elapsed > ZERO:
        return ZERO
    if i[at.HAVE_SAMPLE] == 0 or elapsed > f[cfg.BRIDGE_LIMIT]:
        _begin_again(f, i, t_ns, dead)
        return ZERO
    i[at.GOOD_SAMPLE_TIME] = t_ns
    i[at.TIME] = t_ns
    if elapsed > f[cfg.LONGEST_INTERVAL]:
        report(i, IMU_GAP)
        lose(f, i, ZERO, elapsed - f[cfg.PERIOD])
        return elapsed
    return dt if dt > QUARTER * elapsed and dt < FOUR * elapsed else elapsed


@kernel
def _begin_again(f, i, t_ns, dead):
    """The first sample after dead time: carry what is known to now, or align again."""
    if i[at.MODE] == NAVIGATING:
        coast(f, i, t_ns)
    if i[at.MODE] != NAVIGATING or dead > f[cfg.ATTITUDE_LOST]:
        i[at.TIME] = t_ns
        begin_levelling(f, i)
    for k in range(THREE):
        f[at.DELTA_ANGLE + k] = ZERO
        f[at.DELTA_VELOCITY + k] = ZERO
    i[at.WINDOW_SAMPLES] = 0
    i[at.GOOD_SAMPLE_TIME] = t_ns
    i[at.HAVE_SAMPLE] = 1


@kernel
def _look_back(f, i, quiet):
    """What the window just closed tells."""
    if i[at.MODE] != NAVIGATING:
        level_by_window(f, i, quiet)
        if i[cfg.REFERENCE_ON] != 0:
            gather_rest(f, i)
        return
    still = quiet and state_is_still(f)
    if still:
        f[at.AT_REST] = ONE
    elif f[at.AT_REST] != ZERO:
        leave_rest(f)
    if was_rest(f, i, quiet) and still and i[cfg.STANDSTILL_ON] != 0:
        rest_updates(f, i)


@kernel
def _advance(f, i, dt, wx, wy, wz, ax, ay, az):
    if i[cfg.TWO_SAMPLE] != 0:
        advance_between_samples(f, i, dt, wx, wy, wz, ax, ay, az)
    else:
        advance_by_mean(f, i, dt, wx, wy, wz, ax, ay, az)


@kernel
def _follow_up(f, i, dt):
    """What the new state brings about."""
    if not state_is_sound(f):
        restart(f, i)
        return
    remember(f, i)
    if i[at.MODE] != NAVIGATING:
        return
    f[at.SINCE_TIME] += dt
    f[at.SINCE_YAW_ANGLE] += dt * f[at.OMEGA_B + 2]
    f[at.SINCE_FORCE] += dt * f[at.FORCE_B]
    f[at.SINCE_FORCE + 1] += dt * f[at.FORCE_B + 1]
    if not f[at.SINCE_TIME] < f[cfg.COVARIANCE_PERIOD]:
        predict(f)
    if i[at.TIME] >= i[at.CHECK_DUE]:
        i[at.CHECK_DUE] = i[at.TIME] + i[cfg.CHECK_NS]
        if not is_sound(f):
            restart(f, i)
            return
        refresh_earth(f, i)
        keep_good_state(f, i)
    if i[cfg.CONSTRAINT_ON] != 0:
        gather_side_speed(f)
        if i[at.TIME] >= i[at.CONSTRAINT_DUE]:
            i[at.CONSTRAINT_DUE] = i[at.TIME] + i[cfg.CONSTRAINT_NS]
            constrain(f, i)
