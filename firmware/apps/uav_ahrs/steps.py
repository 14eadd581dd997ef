"""What the tasks do with a burst and with three samples: a kernel call each.

The same steps for the loop in fixed point stand in `fixed_steps`.
"""

from typing import Final

import numpy as np

from firmware.apps.uav_ahrs.disagreement import follow_correction
from firmware.apps.uav_ahrs.holding import give_back, withhold_force
from firmware.apps.uav_ahrs.plausibility import (
    FAILED_ROW,
    LOST_READS,
    MOVES,
    RATES_ROW,
    STALE_ROW,
    STILL,
    count_still,
    hold_force,
    is_gyro_frozen,
    is_jump,
)
from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.burst_words import WORDS, look_at
from firmware.nav.attitude.loop import bridge, iterate, take_words
from firmware.nav.drift import layout as drift
from firmware.nav.drift.correction import correct
from firmware.numerics.dialect import kernel

HOLD_READS: Final = 25
"""0.1 s: rates that old say nothing about the motion now."""
NO_SAMPLE: Final = fl.NO_ANSWER | fl.SLIPPED
RATES_LOST_PLACE: Final = fl.NOTICE_NAMES.index("rates_lost")
READY: Final = 1 << 16
"""Returned beside what was noticed: three samples wait for an iteration."""

SPOILT: Final = 2
"""Returned by an iteration that found or left a state that is none."""
LEAST_NORM = np.float32(0.81)
MOST_NORM = np.float32(1.21)
"""|q|² of a state that is one."""
FASTEST = np.float32(1.0e5)
"""m/s; also what not-a-number is not below."""
ZERO = np.float32(0.0)


@kernel
def words_of(raw, words):
    """The 14 words behind the request's in a burst of 30 bytes."""
    for n in range(np.int32(WORDS)):
        words[n] = (np.int64(raw[2 + 2 * n]) << 8) | np.int64(raw[3 + 2 * n])


@kernel
def is_to_bridge(i, k, words):
    """Whether these words are no sample although they look like one; keeps the rows of failures."""
    found = look_at(i, words)
    k[STALE_ROW] = k[STALE_ROW] + np.int64(1) if found & fl.STALE != 0 else np.int64(0)
    failed = found & (NO_SAMPLE | fl.STALE) != 0
    k[FAILED_ROW] = k[FAILED_ROW] + np.int64(1) if failed else np.int64(0)
    if found & NO_SAMPLE != 0:
        return False
    if found & fl.STALE == 0:
        count_still(k, words)
        if i[at.MODE] != fl.RUNNING and k[STILL] == np.int64(0):
            k[MOVES] += np.int64(1)
    hold_force(k, words)
    return k[STALE_ROW] > np.int64(HOLD_READS) or is_jump(k, words, found & fl.GYRO_SATURATED != 0)


@kernel
def ready(i, found):
    """What is returned of a burst."""
    waits = i[at.MODE] == fl.RUNNING and i[at.IN_RING] == np.int64(3)
    return found | np.int64(READY) if waits else found


@kernel
def forget_old_rates(s, i, k):
    """Rates that have stood for too long become those of a body at rest, and are told to be lost."""
    lost = k[RATES_ROW] > np.int64(HOLD_READS) or is_gyro_frozen(k)
    if lost and i[at.NOTICED] & fl.RATES_LOST == 0:
        i[at.NOTICED] |= fl.RATES_LOST
        i[at.NOTICED_SINCE] |= fl.RATES_LOST
        i[at.NOTICES + RATES_LOST_PLACE] += 1
    if lost or k[FAILED_ROW] > np.int64(HOLD_READS):
        k[LOST_READS] += np.int64(1)
        for n in range(np.int32(3)):
            s[at.OMEGA + at.NEWEST + n] = s[at.GYRO_BIAS + n]


@kernel("int64(float32[::1], int64[::1], int64[::1], uint8[::1], int64[::1])")
def take_burst(s, i, k, raw, words):
    """A burst into the ring of samples; returns what was noticed (`nav.attitude.flags`) and READY."""
    words_of(raw, words)
    found = bridge(s, i) if is_to_bridge(i, k, words) else take_words(s, i, words)
    forget_old_rates(s, i, k)
    return ready(i, found)


@kernel
def is_sound(s):
    """Whether quaternion and velocity are numbers, and such as they can be."""
    norm = ZERO
    for n in range(np.int32(4)):
        norm += s[at.QUATERNION + n] * s[at.QUATERNION + n]
    sound = norm > LEAST_NORM and norm < MOST_NORM
    for n in range(np.int32(3)):
        sound = sound and abs(s[at.VELOCITY + n]) < FASTEST
    return sound


@kernel
def put_back(s, before):
    """Everything but the samples as it was after the last sound iteration."""
    for n in range(np.int32(at.OMEGA)):
        s[n] = before[n]
    for n in range(np.int32(at.C_N_B), np.int32(at.S_SIZE)):
        s[n] = before[n]


@kernel
def remember(s, before):
    """This is a sound state."""
    for n in range(np.int32(at.S_SIZE)):
        before[n] = s[n]


@kernel("int64(float32[::1], int64[::1], float32[::1])")
def iteration(s, i, before):
    """One iteration; 1 when made, 0 when samples are missing, SPOILT when the state was none and what stood
    in `before` (S_SIZE), the state after the last sound iteration, was put in its place."""
    spoilt = not is_sound(s)
    if spoilt:
        put_back(s, before)
    made = iterate(s, i)
    if made == np.int64(0):
        return made
    if not is_sound(s):
        put_back(s, before)
        spoilt = True
    remember(s, before)
    return np.int64(SPOILT) if spoilt else made


@kernel("int64(float32[::1], int64[::1], float32[::1], float32[::1], int64[::1], float32[::1])")
def corrected_iteration(s, i, before, d, m, g):
    """`iteration`, and the drift compensation behind it. `d`, `m`: its memory; `g`: of
    `holding` and `disagreement`."""
    made = iteration(s, i, before)
    if made != np.int64(0):
        regaining = m[drift.FLAGS] & drift.REGAINING != 0
        withhold_force(s, g, regaining)
        q = at.QUATERNION
        w, x, y, z = s[q], s[q + 1], s[q + 2], s[q + 3]
        correct(s, i, d, m)
        give_back(s, g)
        follow_correction(s, g, regaining, w, x, y, z)
    return made
