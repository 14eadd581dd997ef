"""The doors of gyro-free navigation: what the navigation processor calls, and when.

    imu_step       each sample, 200 Hz, of every filter (firmware.nav.imu)
    compass_step   each compass reading, 10 Hz
    gps_step       each GPS epoch, 1 Hz
    fusion_step    after all of these, 1 Hz

`g`, `n`: the sensor and the federation (layout). `f1`, `i1` the compass filter, `f2`, `i2` the GPS filter,
`fm`, `im` the master, whose state is the solution (firmware.nav.solution.solution(fm, im, …)). A centralised
filter is a pair of its own with a `g` and `n` of its own, fed by imu_step, compass_step and gps_step.
`packet_door` does all of it for one packet.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.compass import compass_update, true_heading
from firmware.nav.gyro_free.federation import (
    fuse_filters,
    know_nothing,
    measure_differences,
    predict_all,
    reset_filters,
)
from firmware.nav.gyro_free.gps import gps_update
from firmware.nav.gyro_free.rate_feedback import feed_rate_back
from firmware.nav.gyro_free.trust import (
    compass_repeats,
    doubt_inertial,
    is_usable,
    judge_filters,
    note_measurement,
    recover_filters,
    reopen,
)
from firmware.nav.history import seconds_between
from firmware.numerics.dialect import kernel

RADIANS_PER_TENTH = np.float32(1.7453292519943295e-3)


@kernel("boolean(float32[::1], int64[::1], float32[::1], int64[::1], int64, int64, int64, int64)")
def compass_step(g, n, f1, i1, heading, pitch, roll, time):
    """Heading (magnetic), pitch, roll in tenths of a degree, valid at `time` (board clock, ns)."""
    if compass_repeats(n, heading, pitch, roll):
        note_measurement(n, gl.COMPASS, False, time)
        return False
    believed = compass_update(
        f1, i1, g, true_heading(g, _radians(heading)), _radians(pitch), _radians(roll), time
    )
    note_measurement(n, gl.COMPASS, believed, time)
    return believed


@kernel("boolean(float32[::1], int64[::1], float32[::1], int64[::1], int64[::1])")
def gps_step(g, n, f2, i2, e):
    """One epoch record with VALID_NS set; epochs without a position count as silence."""
    if not e[gnss.FLAGS] & gnss.HAS_POSITION:
        return False
    believed = gps_update(f2, i2, g, e, seconds_between(n[gl.LAST + gl.GPS], e[gnss.VALID_NS]))
    note_measurement(n, gl.GPS, believed, e[gnss.VALID_NS])
    return believed


@kernel(
    "boolean(float32[::1], int64[::1], float32[::1], int64[::1], float32[::1], int64[::1],"
    " float32[::1], int64[::1])"
)
def fusion_step(g, n, f1, i1, f2, i2, fm, im):
    """Fuse what is trusted into the master and reset the filters; False: nothing to fuse."""
    predict_all(f1, f2, fm)
    measure_differences(g, n, f1, i1, f2, i2, fm, im)
    judge_filters(g, n, f1, i1, f2, i2, im[at.TIME])
    if not is_usable(fm, im):
        know_nothing(g, fm, True)
    fused = fuse_filters(g, n, f1, i1, f2, i2, fm, im)
    n[gl.FUSIONS] += 1
    reopen(g, n, fm)
    doubt_inertial(n, fm)
    recovered = recover_filters(n)
    reset_filters(g, n, f1, i1, f2, i2, fm, im, recovered)
    if n[gl.RATE_IS_OWN] != 0 and is_usable(fm, im):
        feed_rate_back(g, f1, f2, fm)
    return fused


@kernel
def _radians(tenths):
    return np.float32(np.int32(tenths)) * RADIANS_PER_TENTH
