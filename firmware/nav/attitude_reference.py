"""The door for the attitude reference: heading, pitch and roll of one record correct the state of now.

The record is that of the GNSS epoch (drivers' `gnss_epoch`), valid at VALID_NS; call this after `gnss_step`
with each record, also with those that hold no angle. Each angle passes a χ² gate of its own. What a refused
heading leads to stands in `reference_trust`, how navigation begins in `reference_start`.
"""

import math

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import reference_layout as ref
from firmware.nav import tuning as cfg
from firmware.nav.covariance import absorb_projected, project, projected_product, remaining_residual
from firmware.nav.dead_time import lost_turn_since
from firmware.nav.feedback import clear_correction, correction_is_sound, feed_back
from firmware.nav.flags import (
    ATTITUDE_REJECTED,
    GNSS_STALE,
    NAVIGATING,
    WAITING,
    WAITING_FOR_HEADING,
    report,
)
from firmware.nav.heading import HALF_PI, wrap_pi
from firmware.nav.history import correct_past, look_up
from firmware.nav.prediction import predict
from firmware.nav.reference_rows import (
    lasting_variance,
    reference_rows,
    single_variance,
    told_angle,
    told_mask,
)
from firmware.nav.reference_start import begin_yaw, note_source
from firmware.nav.reference_trust import forget_refusals, length_fits, note_refusal
from firmware.nav.restart import restart
from firmware.numerics.dialect import kernel
from firmware.numerics.wide_integers import int64_of_float32

ZERO = np.float32(0.0)
NS_PER_SECOND = np.float32(1.0e9)
ANGLES = np.int32(ref.ANGLES)


@kernel("void(float32[::1], int64[::1], int64[::1])")
def attitude_step(f, i, e):
    """Use the angles of one record; without a reference on this board nothing happens."""
    if i[cfg.REFERENCE_ON] == 0 or i[at.MODE] == WAITING or i[at.EPOCHS_TO_WAIT] > 0:
        return
    mask = told_mask(e)
    if mask & 1 == 0:
        i[ref.MISSING] += 1
    time = e[gnss.VALID_NS] - int64_of_float32(f[at.LATENCY] * NS_PER_SECOND)
    note_source(i)
    if i[at.MODE] == NAVIGATING:
        if mask != 0:
            _correct(f, i, e, time, mask)
    elif i[at.MODE] == WAITING_FOR_HEADING:
        begin_yaw(f, i, e, time, mask & 1 != 0)


@kernel
def _correct(f, i, e, time, mask):
    predict(f)
    if not look_up(f, i, time):
        report(i, GNSS_STALE)
        return
    correct_past(f, i, time)
    _begin_record(f, i, time)
    if not length_fits(f, e):
        i[ref.WRONG_LENGTH] += 1
        report(i, ATTITUDE_REJECTED)
        return
    if not reference_rows(f):
        return
    clear_correction(f)
    for angle in range(ANGLES):
        if (mask >> angle) & 1:
            _absorb_angle(f, i, e, time, angle)
    if i[ref.MASK] == 0:
        return
    if not correction_is_sound(f):
        restart(f, i)
        return
    feed_back(f, i)
    i[ref.USED] += 1


@kernel
def _begin_record(f, i, time):
    i[ref.TIME] = time
    i[ref.MASK] = 0
    for k in range(ANGLES):
        f[ref.INNOVATION + k] = ZERO
        f[ref.INNOVATION_SIGMA + k] = ZERO


@kernel
def _absorb_angle(f, i, e, time, angle):
    """Update by one angle, if it passes."""
    residual = wrap_pi(told_angle(e, angle) - f[ref.PREDICTED + angle])
    lost_tilt, lost_yaw = lost_turn_since(f, i, time)
    variance = single_variance(f, e, angle) + (lost_yaw if angle == ref.HEADING else lost_tilt)
    f[at.RESIDUAL + angle] = residual
    project(f, angle)
    s = projected_product(f, angle, angle) + variance
    f[ref.INNOVATION + angle] = residual
    f[ref.INNOVATION_SIGMA + angle] = np.float32(math.sqrt(s))
    remaining = remaining_residual(f, angle)
    passes = remaining * remaining <= f[cfg.GATE_1] * s and abs(residual) < HALF_PI
    if passes:
        f[at.VARIANCE + angle] = variance + lasting_variance(f, i, time, angle)
        absorb_projected(f, angle)
        i[ref.MASK] |= np.int64(1) << angle
        i[ref.LAST_USED + angle] = time
    if angle == ref.HEADING:
        if passes:
            forget_refusals(i)
        else:
            note_refusal(f, i, e, time, residual, variance)
