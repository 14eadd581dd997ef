"""When is a heading believed that contradicts the inertial one?

Gyros of this class hold a heading for minutes better than two antennas measure it, so a heading that does not
pass the gate is wrong: ambiguities fixed to wrong numbers (the vector's length tells most of them), a
reflection, antennas confused (180 degrees). It is refused, again and again. The inertial heading can be
wrong too, if the start was or a gyro is; then the refused headings agree with one another, and after
`rejoin_after` of that

    off by up to 90 degrees      yaw is made as uncertain as they are off, and the gate opens, when the
                                 course is a witness: over at least ten epochs of straight driving it is far
                                 nearer to them than to the inertial yaw
    by less than `small_refusal` without a witness too, after ten times as long: no course could tell
    by more than 90 degrees      never; but when the velocity has been refused for some seconds as well, two
                                 stand against one: alignment begins anew

A gyro that runs away makes a row of refused headings that do not agree with one another. When heading and
velocity have both been refused for `TEN_SECONDS` without a break, alignment begins anew as well.

A course serves modulo 180 degrees, as a vehicle may drive backwards; it cannot speak for a flipped baseline.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav import tuning as cfg
from firmware.nav.covariance import add_variance
from firmware.nav.flags import ATTITUDE_REJECTED, REALIGNED, REJOINED, report
from firmware.nav.heading import HALF_PI, PI, course_and_speed, has_course, wrap_pi
from firmware.nav.levelling import begin_levelling
from firmware.numerics.dialect import kernel
from firmware.numerics.quaternion import euler_of_quaternion

ZERO = np.float32(0.0)
QUARTER = np.float32(0.25)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
EIGHTH = np.float32(0.125)
MILLI = np.float32(1.0e-3)
ENOUGH_WITNESSED = np.int64(10)
TEN = np.int64(10)
SOME_SECONDS = np.int64(4_000_000_000)
TEN_SECONDS = np.int64(10_000_000_000)


@kernel
def length_fits(f, e):
    """Whether the vector is as long as the baseline, if the record tells."""
    if not e[gnss.FLAGS] & gnss.HAS_BASELINE:
        return True
    length = np.float32(np.int32(min(e[gnss.BASELINE_MM], np.int64(1_000_000_000)))) * MILLI
    return abs(length - f[ref.LENGTH]) <= f[ref.LENGTH_TOLERANCE]


@kernel
def forget_refusals(i):
    """The last heading was well."""
    i[ref.REFUSED_SINCE] = at.NEVER


@kernel
def note_refusal(f, i, e, time, residual, variance):
    """A heading (its `residual`, and the `variance` of one) did not pass; may be the last of its row."""
    flipped = not abs(residual) < HALF_PI
    if flipped:
        i[ref.FLIPPED] += 1
    else:
        i[ref.REFUSED] += 1
    off = wrap_pi(residual - f[ref.REFUSED_MEAN])
    first = i[ref.REFUSED_SINCE] == at.NEVER
    if flipped or not first:
        report(i, ATTITUDE_REJECTED)
    if first or not off * off <= f[cfg.GATE_1] * TWO * variance:
        i[ref.REFUSED_SINCE] = time
        i[ref.WITNESSED] = 0
        i[ref.VELOCITY_TOO] = 0
        f[ref.REFUSED_MEAN] = residual
        f[ref.AGAINST_INERTIAL] = ZERO
        f[ref.AGAINST_REFERENCE] = ZERO
    else:
        f[ref.REFUSED_MEAN] = wrap_pi(f[ref.REFUSED_MEAN] + EIGHTH * off)
    since = i[at.VELOCITY_REFUSED_SINCE]
    if since != at.NEVER and time - since >= SOME_SECONDS:
        i[ref.VELOCITY_TOO] = 1
    if since != at.NEVER and time - max(since, i[ref.LAST_USED + ref.HEADING]) >= TEN_SECONDS:
        _align_again(f, i)
        return
    _hear_course(f, i, e)
    lasted = time - i[ref.REFUSED_SINCE]
    if lasted >= i[ref.REJOIN_NS]:
        _decide(f, i, flipped, lasted >= TEN * i[ref.REJOIN_NS])


@kernel
def _hear_course(f, i, e):
    """What the course over ground says about both, if the vehicle drives straight and fast enough."""
    if not has_course(e):
        return
    course, speed = course_and_speed(e)
    if not speed > f[cfg.HEADING_CHECK_SPEED] or abs(f[at.AGO_RATE + 2]) > f[cfg.HEADING_MAX_RATE]:
        return
    q = at.AGO_QUATERNION
    yaw, _, _ = euler_of_quaternion(f[q], f[q + 1], f[q + 2], f[q + 3])
    inertial = _as_line(wrap_pi(wrap_pi(course - yaw)))
    reference = _as_line(wrap_pi(inertial - f[ref.REFUSED_MEAN]))
    f[ref.AGAINST_INERTIAL] += inertial * inertial
    f[ref.AGAINST_REFERENCE] += reference * reference
    i[ref.WITNESSED] += 1


@kernel
def _as_line(angle):
    """An angle in [−π, π) modulo π, in [−π/2, π/2)."""
    if angle >= HALF_PI:
        return angle - PI
    if angle < -HALF_PI:
        return angle + PI
    return angle


@kernel
def _decide(f, i, flipped, very_long):
    if flipped:
        if i[ref.VELOCITY_TOO] != 0:
            _align_again(f, i)
        return
    witnessed = i[ref.WITNESSED] >= ENOUGH_WITNESSED
    outvoted = witnessed and f[ref.AGAINST_REFERENCE] < QUARTER * f[ref.AGAINST_INERTIAL]
    mean = f[ref.REFUSED_MEAN]
    if outvoted or (very_long and abs(mean) < f[ref.SMALL_REFUSAL]):
        add_variance(f, at.X_ATTITUDE + 2, mean * mean)
        report(i, REJOINED)
        forget_refusals(i)


@kernel
def _align_again(f, i):
    """The receiver's heading and its velocity stand against the inertial solution."""
    report(i, REALIGNED)
    forget_refusals(i)
    begin_levelling(f, i)
