"""Which filter is trusted: detection, isolation and recovery of one whose sensor fails.

detected   measurements refused by their gate, counted up, accepted ones counted down; a compass that says
           the same for seconds; no measurement for some seconds; or an estimate that differs from the
           master's by more than both allow (largest of the whitened differences; not without
           resets, when filters go apart by what each cannot observe)
isolated   it gives nothing to the fusion and takes the global state at each
recovered  so many measurements in a row agree with the global state again
reopened   refused for minutes without end: it may be the global state that is wrong (reopen)
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav.covariance import add_variance, is_sound
from firmware.nav.flags import NAVIGATING
from firmware.nav.gyro_free import layout as gl
from firmware.nav.history import seconds_between
from firmware.nav.restart import state_is_sound
from firmware.numerics.dialect import kernel

ZERO = np.int64(0)
TWO = np.int32(2)
DOUBT_POSITION = np.float32(50.0 * 50.0)
DOUBT_VELOCITY = np.float32(5.0 * 5.0)
DOUBT_ATTITUDE = np.float32(0.15 * 0.15)
DOUBT_RATE = np.float32(0.1 * 0.1)
"""What a second in doubt adds: m², (m/s)², rad², (rad/s)²."""
THREE = np.int32(3)


@kernel
def is_usable(f, i):
    """Whether a filter navigates and all of it are numbers."""
    return i[at.MODE] == NAVIGATING and state_is_sound(f) and is_sound(f)


@kernel
def note_measurement(n, which, believed, time):
    """One measurement of a filter was believed or not."""
    n[gl.LAST + which] = time
    if believed:
        n[gl.USED + which] += 1
        n[gl.GOOD + which] += 1
        n[gl.SCORE + which] = max(n[gl.SCORE + which] - 1, ZERO)
        n[gl.REFUSED_IN_A_ROW + which] = 0
        return
    n[gl.REFUSED_IN_A_ROW + which] += 1
    n[gl.REFUSED_MEASUREMENTS + which] += 1
    n[gl.GOOD + which] = 0
    n[gl.SCORE + which] += 1
    if n[gl.SCORE + which] >= n[gl.LIMIT_SCORE + which]:
        _isolate(n, which, gl.CONTRADICTED)


@kernel
def compass_repeats(n, heading, pitch, roll):
    """Whether the compass has said the same for too long: its noise is more than a digit."""
    w = gl.COMPASS_WORDS
    if heading == n[w] and pitch == n[w + 1] and roll == n[w + 2]:
        n[gl.REPEATS] += 1
    else:
        n[gl.REPEATS] = 0
    n[w] = heading
    n[w + 1] = pitch
    n[w + 2] = roll
    return n[gl.REPEATS] >= n[gl.LIMIT_REPEATS]


@kernel
def judge_filters(g, n, f1, i1, f2, i2, time):
    """Before a fusion: who began anew, who is silent, who differs; at most one of the two for differing."""
    if not is_usable(f1, i1):
        n[gl.GOOD] = 0
        _isolate(n, gl.COMPASS, gl.BROKEN)
    if not is_usable(f2, i2):
        n[gl.GOOD + 1] = 0
        _isolate(n, gl.GPS, gl.BROKEN)
    for k in range(TWO):
        if time - n[gl.LAST + k] > n[gl.LIMIT_SILENCE + k]:
            n[gl.GOOD + k] = 0
            _isolate(n, k, gl.SILENT)
    worse = 0 if g[gl.WORST] > g[gl.WORST + 1] else 1
    if n[gl.MODE] != gl.NO_RESET and g[gl.WORST + worse] > g[gl.GATE_DIFFERENCE]:
        n[gl.GOOD + worse] = 0
        _isolate(n, worse, gl.DIFFERENT)


@kernel
def recover_filters(n):
    """After a fusion: who may be trusted again; whether anyone is."""
    recovered = False
    for k in range(TWO):
        if n[gl.STATUS + k] == gl.ISOLATED and n[gl.GOOD + k] >= n[gl.LIMIT_GOOD + k]:
            n[gl.STATUS + k] = gl.TRUSTED
            n[gl.SCORE + k] = 0
            n[gl.RECOVERIES + k] += 1
            n[gl.ISOLATED_BY + k] = gl.NO_CAUSE
            recovered = True
    return recovered


@kernel
def reopen(g, n, fm):
    """A sensor whose measurements have been refused for minutes may be right after all: the master, and with
    it whoever takes its state, becomes so uncertain that the next ones pass."""
    if n[gl.REFUSED_IN_A_ROW + gl.COMPASS] >= n[gl.LIMIT_REFUSED + gl.COMPASS]:
        n[gl.REFUSED_IN_A_ROW + gl.COMPASS] = 0
        n[gl.REOPENED + gl.COMPASS] += 1
        for k in range(THREE):
            add_variance(fm, at.X_ATTITUDE + k, g[gl.NO_INFORMATION + 2])
    if n[gl.REFUSED_IN_A_ROW + gl.GPS] >= n[gl.LIMIT_REFUSED + gl.GPS]:
        n[gl.REFUSED_IN_A_ROW + gl.GPS] = 0
        n[gl.REOPENED + gl.GPS] += 1
        for k in range(THREE):
            add_variance(fm, at.X_POSITION + k, g[gl.NO_INFORMATION])
            add_variance(fm, at.X_VELOCITY + k, g[gl.NO_INFORMATION + 1])


@kernel
def doubt_inertial(n, fm):
    """Both sensors are contradicted: it is the inertial state that is wrong, and becomes uncertain; each
    fusion adds its part of a second's doubt."""
    both = n[gl.STATUS] == gl.ISOLATED and n[gl.STATUS + 1] == gl.ISOLATED
    if not both or (n[gl.ISOLATED_BY] == gl.SILENT and n[gl.ISOLATED_BY + 1] == gl.SILENT):
        return
    second = seconds_between(ZERO, n[gl.FUSION_NS])
    for k in range(THREE):
        add_variance(fm, at.X_POSITION + k, DOUBT_POSITION * second)
        add_variance(fm, at.X_VELOCITY + k, DOUBT_VELOCITY * second)
        add_variance(fm, at.X_ATTITUDE + k, DOUBT_ATTITUDE * second)
        add_variance(fm, at.X_GYRO_BIAS + k, DOUBT_RATE * second)


@kernel
def _isolate(n, which, cause):
    if n[gl.STATUS + which] == gl.ISOLATED:
        return
    n[gl.STATUS + which] = gl.ISOLATED
    n[gl.ISOLATED_BY + which] = cause
    n[gl.ISOLATIONS + which] += 1
