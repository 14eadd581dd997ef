"""Yaw at the beginning, of a vehicle that was levelled at rest: from the reference, else from the gyros.

Some headings in a row must agree, each compared with the level axes n' that the gyros hold; and their mean
must not contradict what the gyros feel of the Earth's rate (gyrocompass) by five of its standard deviations.
With good gyros that is 12 degrees after ten seconds, so that a flipped baseline does not begin navigation
either; with poor ones it is no limit.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav import tuning as cfg
from firmware.nav.flags import ATTITUDE_REJECTED, NAVIGATING, report
from firmware.nav.gyrocompass import begin_by_compass, compass_is_due, compass_turn, compass_variance
from firmware.nav.heading import HALF_PI, begin_after_rest, wrap_pi
from firmware.nav.history import look_up
from firmware.nav.reference_rows import reference_rows, single_variance, told_angle
from firmware.nav.reference_trust import forget_refusals, length_fits
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FIVE_SIGMA_SQUARE = np.float32(25.0)
LEAST_CONTRADICTION = np.float32(0.05)


@kernel
def begin_yaw(f, i, e, time, has_heading):
    """Use a record, valid at `time`, of a vehicle that waits for its heading."""
    if not look_up(f, i, time):
        return
    has_fix = i[at.FIX_TIME] == e[gnss.VALID_NS]
    if has_heading:
        _gather(f, i, e)
        if has_fix and i[ref.START_COUNT] >= i[ref.FIRST_EPOCHS] and not _is_contradicted(f, i, e):
            count = np.float32(np.int32(i[ref.START_COUNT]))
            single = single_variance(f, e, ref.HEADING)
            variance = (single - f[ref.ERROR_VARIANCE]) / count + f[ref.ERROR_VARIANCE]
            begin_after_rest(f, i, e, time, f[ref.START_TURN], variance)
            i[ref.LAST_USED] = time
            i[ref.USED] += 1
            _entered(f, i, ref.BASELINE)
    if has_fix and compass_is_due(f, i):
        begin_by_compass(f, i, e, time)
        _entered(f, i, ref.GYROCOMPASS)


@kernel
def _entered(f, i, source):
    i[ref.YAW_SOURCE] = source
    forget_refusals(i)
    f[at.AT_REST] = ONE if i[at.LEVEL_WINDOWS] > 0 else ZERO


@kernel
def _gather(f, i, e):
    """Count the records in a row that agree; layout START_TURN is their mean."""
    if not length_fits(f, e):
        i[ref.WRONG_LENGTH] += 1
        report(i, ATTITUDE_REJECTED)
        return
    if not reference_rows(f):
        return
    turn = wrap_pi(told_angle(e, ref.HEADING) - f[ref.PREDICTED])
    off = wrap_pi(turn - f[ref.START_TURN])
    if i[ref.START_COUNT] > 0 and off * off > f[cfg.GATE_1] * TWO * single_variance(f, e, ref.HEADING):
        i[ref.START_COUNT] = 0
        i[ref.REFUSED] += 1
    if i[ref.START_COUNT] == 0:
        f[ref.START_TURN] = turn
        i[ref.START_COUNT] = 1
        return
    if i[ref.START_COUNT] < 60:
        i[ref.START_COUNT] += 1
    f[ref.START_TURN] = wrap_pi(f[ref.START_TURN] + off / np.float32(np.int32(i[ref.START_COUNT])))


@kernel
def _is_contradicted(f, i, e):
    """Whether the gyros feel the Earth turn about another axis."""
    off = wrap_pi(f[ref.START_TURN] - compass_turn(f))
    limit = FIVE_SIGMA_SQUARE * (compass_variance(f, i) + single_variance(f, e, ref.HEADING))
    if off * off <= max(limit, LEAST_CONTRADICTION * LEAST_CONTRADICTION):
        return False
    if abs(off) < HALF_PI:
        i[ref.REFUSED] += 1
    else:
        i[ref.FLIPPED] += 1
    report(i, ATTITUDE_REJECTED)
    return True


@kernel
def note_source(i):
    """Remember where the yaw came from when it was not from here."""
    if i[at.MODE] != NAVIGATING:
        i[ref.YAW_SOURCE] = ref.NO_YAW
    elif i[ref.YAW_SOURCE] == ref.NO_YAW:
        i[ref.YAW_SOURCE] = ref.GIVEN if i[cfg.YAW_IS_GIVEN] != 0 else ref.COURSE
        i[ref.START_COUNT] = 0
        forget_refusals(i)
