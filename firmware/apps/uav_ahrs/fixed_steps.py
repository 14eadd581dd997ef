"""The steps of the tasks for the loop in fixed point; see `steps`. No float occurs."""

import numpy as np

from firmware.apps.uav_ahrs.fixed_disagreement import follow_correction
from firmware.apps.uav_ahrs.fixed_holding import give_back, withhold_force
from firmware.apps.uav_ahrs.steps import (
    SPOILT,
    forget_old_rates,
    is_to_bridge,
    put_back,
    ready,
    remember,
    words_of,
)
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.fixed.loop import bridge, iterate, take_words
from firmware.nav.drift.fixed import layout as drift
from firmware.nav.drift.fixed.correction import correct
from firmware.nav.drift.layout import REGAINING
from firmware.numerics.dialect import kernel

HALF_Q = 15
"""The quaternion has Q30; its squares are summed in as many bits."""
LEAST_NORM = np.int64(869_730_878)
MOST_NORM = np.int64(1_299_227_607)
"""0.81 and 1.21 in Q30."""


@kernel("int64(int32[::1], int64[::1], int64[::1], uint8[::1], int64[::1])")
def take_burst(s, i, k, raw, words):
    """As `steps.take_burst`."""
    words_of(raw, words)
    found = bridge(s, i) if is_to_bridge(i, k, words) else take_words(s, i, words)
    forget_old_rates(s, i, k)
    return ready(i, found)


@kernel
def is_sound(s):
    """Whether the quaternion is one; velocities saturate."""
    norm = np.int64(0)
    for n in range(np.int32(4)):
        part = np.int64(s[at.QUATERNION + n]) >> np.int64(HALF_Q)
        norm += part * part
    return norm > LEAST_NORM and norm < MOST_NORM


@kernel("int64(int32[::1], int64[::1], int32[::1])")
def iteration(s, i, before):
    """As `steps.iteration`."""
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


@kernel("int64(int32[::1], int64[::1], int32[::1], int32[::1], int64[::1], int64[::1])")
def corrected_iteration(s, i, before, d, m, g):
    """As `steps.corrected_iteration`."""
    made = iteration(s, i, before)
    if made != np.int64(0):
        regaining = m[drift.FLAGS] & REGAINING != 0
        withhold_force(s, i, g, regaining)
        q = at.QUATERNION
        w, x, y, z = np.int64(s[q]), np.int64(s[q + 1]), np.int64(s[q + 2]), np.int64(s[q + 3])
        correct(s, i, d, m)
        give_back(s, g)
        follow_correction(s, g, regaining, w, x, y, z)
    return made
