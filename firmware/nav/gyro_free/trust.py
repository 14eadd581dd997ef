"""Which filter is trusted: detection, isolation and recovery of one whose sensor fails.

detected   measurements refused by their gate, counted up, accepted ones counted down; a compass that says
           the same for seconds; no measurement for some seconds; or an estimate that differs from the
           master's by more than both allow (largest of the whitened differences; not without
           resets, when filters go apart by what each cannot observe)
isolated   it gives nothing to the fusion and takes the global state at each
recovered  so many measurements in a row agree with the global state again
"""

import numpy as np

from firmware.nav.gyro_free import layout as gl
from firmware.numerics.dialect import kernel

ZERO = np.int64(0)
TWO = np.int32(2)


@kernel
def note_measurement(n, which, believed, time):
    """One measurement of a filter was believed or not."""
    n[gl.LAST + which] = time
    if believed:
        n[gl.USED + which] += 1
        n[gl.GOOD + which] += 1
        n[gl.SCORE + which] = max(n[gl.SCORE + which] - 1, ZERO)
        return
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
def judge_filters(g, n, time):
    """Before a fusion: who is silent, who differs; at most one of the two for differing."""
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
def _isolate(n, which, cause):
    if n[gl.STATUS + which] == gl.ISOLATED:
        return
    n[gl.STATUS + which] = gl.ISOLATED
    n[gl.ISOLATED_BY + which] = cause
    n[gl.ISOLATIONS + which] += 1
