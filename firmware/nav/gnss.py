"""The door for GNSS: one epoch of the receiver, at most a second old, corrects the state of now.

An epoch is compared with the state of its own time of validity (history), its position (3, or 2 when the
height is held) and its velocity (3, or along and across the course; none below 1 m/s) each pass a χ² gate of
their own before anything is absorbed. What is refused for long is believed in the end: the refused states
are made as uncertain as the innovation is large, and the gate opens. After an outage patience is shorter.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.covariance import add_variance
from firmware.nav.dead_time import coast, lost_since
from firmware.nav.earth import refresh_earth
from firmware.nav.feedback import clear_correction, correction_is_sound, feed_back
from firmware.nav.flags import (
    GNSS_REJECTED,
    GNSS_STALE,
    LEVELLING,
    NAVIGATING,
    REALIGNED,
    REJOINED,
    WAITING,
    WAITING_FOR_HEADING,
    report,
)
from firmware.nav.gnss_measurement import (
    epoch_height,
    epoch_velocity,
    position_rows,
    turn_velocity_rows,
    velocity_rows,
)
from firmware.nav.gnss_noise import (
    add_lasting_error,
    position_variances,
    speed_variance,
    weigh_epoch,
    weigh_lasting_error,
)
from firmware.nav.gnss_scatter import keep_residual, learn_scatter
from firmware.nav.gnss_time import time_is_believed
from firmware.nav.heading import find_heading, has_course, heading_is_wrong
from firmware.nav.history import correct_past, look_up
from firmware.nav.levelling import begin_levelling
from firmware.nav.measurement import absorb_group, clear_rows, weigh_group
from firmware.nav.motion_alignment import align_in_motion
from firmware.nav.prediction import predict
from firmware.nav.restart import restart
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import units_of_nanodegrees
from firmware.numerics.wide_integers import int64_of_float32

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
MILLI = np.float32(1.0e-3)
HOPELESS = np.float32(1.0e12)
"""A weight beyond is no number to work with."""
NS_PER_SECOND = np.float32(1.0e9)
LEAST_SPEED_MMPS = np.int64(1000)
LOW_PASS = np.float32(0.4)
LOW_PASS_RESET = np.float32(0.3)
TWO_DIMENSIONAL = np.int64(2)
THREE = np.int32(3)
POSITION_ROWS = 0
VELOCITY_ROWS = 3


@kernel("void(float32[::1], int64[::1], int64[::1])")
def gnss_step(f, i, e):
    """Use one epoch record (drivers' `gnss_epoch`); VALID_NS must be set by the caller."""
    if not e[gnss.FLAGS] & gnss.HAS_POSITION or i[at.MODE] == WAITING:
        return
    if not time_is_believed(i, e):
        return
    valid = e[gnss.VALID_NS]
    if valid - i[at.TIME] > i[cfg.SILENCE_NS]:
        _go_on_without_samples(f, i, valid)
    time = valid - int64_of_float32(f[at.LATENCY] * NS_PER_SECOND)
    weigh_epoch(f, i, valid)
    outage = valid - i[at.FIX_TIME] > i[cfg.GNSS_LOST_NS]
    _note_fix(f, i, e)
    if i[at.MODE] == NAVIGATING:
        if outage:
            i[at.PATIENCE_NS] = i[cfg.REJOIN_AFTER_OUTAGE_NS]
        _correct(f, i, e, time)
    elif i[at.MODE] == WAITING_FOR_HEADING:
        find_heading(f, i, e, time)
    elif i[at.MODE] == LEVELLING:
        align_in_motion(f, i, e, time)


@kernel
def _go_on_without_samples(f, i, valid):
    """The sensor is silent: time goes on by the epochs, position by velocity if there is one."""
    if i[at.MODE] == NAVIGATING:
        coast(f, i, valid)
        return
    i[at.TIME] = valid
    i[at.HAVE_SAMPLE] = 0
    begin_levelling(f, i)


@kernel
def _note_fix(f, i, e):
    """Keep the fix for alignment, for what is shown before, and for the question whether it moves."""
    i[at.FIX_TIME] = e[gnss.VALID_NS]
    i[at.FIX_LATITUDE] = units_of_nanodegrees(e[gnss.LAT_NANODEG])
    i[at.FIX_LONGITUDE] = units_of_nanodegrees(e[gnss.LON_NANODEG])
    if e[gnss.FLAGS] & gnss.HAS_HEIGHT:
        f[at.GNSS_FIX] = epoch_height(e)
    north, east, down = epoch_velocity(e)
    f[at.GNSS_FIX + 1] = north
    f[at.GNSS_FIX + 2] = east
    f[at.GNSS_FIX + 3] = down
    horizontal, vertical = position_variances(f, e)
    f[at.GNSS_FIX + 4] = horizontal + f[cfg.POSITION_ERROR_VARIANCE_H]
    f[at.GNSS_FIX + 5] = vertical + f[cfg.POSITION_ERROR_VARIANCE_V]
    f[at.GNSS_FIX + 6] = speed_variance(f, e)
    s = at.GNSS_SPEED
    dn = north - f[s]
    de = east - f[s + 1]
    dd = down - f[s + 2]
    gain = LOW_PASS if abs(dn) + abs(de) + abs(dd) < LOW_PASS_RESET else ONE
    f[s] += gain * dn
    f[s + 1] += gain * de
    f[s + 2] += gain * dd


@kernel
def _correct(f, i, e, time):
    predict(f)
    refresh_earth(f, i)
    if not look_up(f, i, time):
        report(i, GNSS_STALE)
        return
    correct_past(f, i, time)
    if i[cfg.CONSTRAINT_ON] != 0 and heading_is_wrong(f, i, e, time):
        report(i, REALIGNED)
        begin_levelling(f, i)
        return
    clear_correction(f)
    clear_rows(f)
    position = _prepare_position(f, i, e, time)
    velocity = _prepare_velocity(f, i, e, time)
    lost_velocity, lost_position = lost_since(f, i, time)
    for k in range(THREE):
        f[at.VARIANCE + POSITION_ROWS + k] += lost_position
        f[at.VARIANCE + VELOCITY_ROWS + k] += lost_velocity
    position_weight = weigh_group(f, POSITION_ROWS, position)
    velocity_weight = weigh_group(f, VELOCITY_ROWS, velocity)
    for k in range(np.int32(at.ROW_LIMIT)):
        f[at.LAST_INNOVATION + k] = f[at.RESIDUAL + k]
        f[at.LAST_INNOVATION_SIGMA + k] = f[at.INNOVATION_SIGMA + k]
    i[at.INNOVATION_TIME] = time
    i[at.INNOVATION_MASK] = 0
    if _position_passes(f, i, time, position, position_weight):
        weigh_lasting_error(f, i, time)
        absorb_group(f, POSITION_ROWS, position)
        i[at.INNOVATION_MASK] = (np.int64(1) << position) - 1
    if velocity > 0 and _velocity_passes(f, i, time, velocity, velocity_weight):
        absorb_group(f, VELOCITY_ROWS, velocity)
        i[at.INNOVATION_MASK] |= ((np.int64(1) << velocity) - 1) << VELOCITY_ROWS
    if i[at.INNOVATION_MASK] & 1:
        keep_residual(f, i, time)
    if not correction_is_sound(f):
        restart(f, i)
        return
    if i[at.POSITION_REFUSED_SINCE] == at.NEVER and i[at.VELOCITY_REFUSED_SINCE] == at.NEVER:
        i[at.PATIENCE_NS] = i[cfg.REJOIN_AFTER_NS]
    if i[at.INNOVATION_MASK] != 0:
        feed_back(f, i)
        i[at.UPDATES] += 1


@kernel
def _prepare_position(f, i, e, time):
    """Rows, residuals and variances of position; the number of rows."""
    position_rows(f, i, e, time)
    learn_scatter(f, i, time)
    horizontal, vertical = position_variances(f, e)
    f[at.VARIANCE] = horizontal
    f[at.VARIANCE + 1] = horizontal
    f[at.VARIANCE + 2] = vertical
    add_lasting_error(f)
    held = e[gnss.FIX_TYPE] == TWO_DIMENSIONAL
    return 2 if held or not e[gnss.FLAGS] & gnss.HAS_HEIGHT else 3


@kernel
def _prepare_velocity(f, i, e, time):
    """The same for velocity: 3 rows NED, or 2 along and across the course, or none."""
    for k in range(THREE):
        f[at.RESIDUAL + VELOCITY_ROWS + k] = ZERO
        f[at.INNOVATION_SIGMA + VELOCITY_ROWS + k] = ZERO
    if not has_course(e):
        return 0
    velocity_rows(f, i, e, time)
    variance = speed_variance(f, e)
    for k in range(THREE):
        f[at.VARIANCE + VELOCITY_ROWS + k] = variance
    if e[gnss.FLAGS] & gnss.HAS_VELOCITY:
        return 3
    f[at.RESIDUAL + VELOCITY_ROWS + 2] = ZERO
    if e[gnss.SPEED_MMPS] < LEAST_SPEED_MMPS:
        return 0
    turn_velocity_rows(f, e)
    speed = np.float32(np.int32(e[gnss.SPEED_MMPS])) * MILLI
    f[at.VARIANCE + VELOCITY_ROWS + 1] = variance + speed * speed * f[cfg.COURSE_VARIANCE]
    return 2


@kernel
def _position_passes(f, i, time, count, weight):
    if weight <= (f[cfg.GATE_3] if count == 3 else f[cfg.GATE_2]):
        i[at.POSITION_REFUSED_SINCE] = at.NEVER
        return True
    if i[at.POSITION_REFUSED_SINCE] == at.NEVER:
        i[at.POSITION_REFUSED_SINCE] = time
    else:
        report(i, GNSS_REJECTED)
    if time - i[at.POSITION_REFUSED_SINCE] < i[at.PATIENCE_NS] or not weight < HOPELESS:
        return False
    _widen(f, POSITION_ROWS, at.X_POSITION, count)
    i[at.POSITION_REFUSED_SINCE] = at.NEVER
    report(i, REJOINED)
    return True


@kernel
def _velocity_passes(f, i, time, count, weight):
    if weight <= (f[cfg.GATE_3] if count == 3 else f[cfg.GATE_2]):
        i[at.VELOCITY_REFUSED_SINCE] = at.NEVER
        return True
    if i[at.VELOCITY_REFUSED_SINCE] == at.NEVER:
        i[at.VELOCITY_REFUSED_SINCE] = time
    else:
        report(i, GNSS_REJECTED)
    if time - i[at.VELOCITY_REFUSED_SINCE] < i[at.PATIENCE_NS] or not weight < HOPELESS:
        return False
    _widen(f, VELOCITY_ROWS, at.X_VELOCITY, count)
    for k in range(THREE):
        add_variance(f, at.X_ATTITUDE + k, f[cfg.WIDEN_ATTITUDE_VARIANCE])
    i[at.VELOCITY_REFUSED_SINCE] = at.NEVER
    report(i, REJOINED)
    return True


@kernel
def _widen(f, row, state, count):
    """Make three states as uncertain as the innovation of their rows is large."""
    square = ZERO
    for k in range(np.int32(count)):
        square += f[at.RESIDUAL + row + k] * f[at.RESIDUAL + row + k]
    for k in range(THREE):
        add_variance(f, state + k, square)
