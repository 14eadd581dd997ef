"""Is a burst of the ADIS16407 one that the last burst can lead to? The bus has no checksum.

`firmware.nav.attitude.burst_words` looks at each burst by itself. Two things show only beside those before:

- a jump: a rate or force further from the last one than two samples in a row can be. It is refused, unless
  the burst before was refused too and said the same: then it is no bit error;
- a chip that samples no more: its registers stand, ND stays clear read after read;
- a triad that is frozen: it shows exactly the same read after read, which noise does not allow.

A force at the end of its range says nothing about the vertical: the one before stands for it. Rates say
nothing when they are at the end of their range without having got there (no motion jumps), or when they are
frozen while forces move: the rates before stand for them, force and field count. A sensor whose rates did
not move in the alignment either has no noise, as in a simulation without errors, and is never called frozen.

Memory `k`, int64: the words believed last, the words refused last, and counts. Bursts are counted by reads.
"""

from typing import Final

import numpy as np

from firmware.nav.attitude.burst_words import ACCEL, GYRO, WORDS, signed_14
from firmware.numerics.dialect import kernel

LAST: Final = 0
REFUSED: Final = 14
REFUSALS: Final = 28
"""In a row."""
JUMPS: Final = 29
"""Bursts refused, all together."""
SEEN: Final = 30
"""Whether LAST holds a burst."""
STALE_ROW: Final = 31
"""Reads in a row without a new sample."""
LOST_READS: Final = 32
"""Reads whose rates were taken for zero."""
FAILED_ROW: Final = 33
"""Reads in a row that brought no sample: nobody there, slipped, stale."""
STILL: Final = 34
"""Reads in a row in which gyro, accelerometer, magnetometer (3) showed exactly the same."""
FORCES_HELD: Final = 37
"""Bursts whose force was out of range, so that the one before stood for it."""
RATES_ROW: Final = 38
"""Reads in a row whose rates were no rates although the burst was one."""
MOVES: Final = 39
"""Reads of the alignment in which rates moved."""
PLAUSIBILITY_SIZE: Final = 40

RATES: Final = 3
INERTIAL: Final = 6
"""Words of the gyro, and of gyro and accelerometer, from GYRO on."""
MOST_REFUSED: Final = 10
"""In a row; what goes on for longer is no disturbance of single bursts."""

FROZEN_READS = np.int64(250)
"""1 s."""
MOVES_OF_NOISE = np.int64(100)
FORCE_LIMIT = np.int64(5_390)
"""18 g in counts of 1/300 g, less a little."""
RATE_STEP = np.int64(500)
"""25 °/s in 4 ms: 6,250 °/s², which a body of this kind does not reach."""
FORCE_STEP = np.int64(900)
"""3 g in 4 ms."""


@kernel
def is_far(k, place, words, count):
    """Whether any of the first `count` inertial words (RATES, INERTIAL) is further from that kept at `place`
    than two samples in a row can be."""
    far = False
    for n in range(np.int32(count)):
        step = signed_14(words[GYRO + n]) - signed_14(k[place + GYRO + n])
        limit = RATE_STEP if n < np.int32(ACCEL - GYRO) else FORCE_STEP
        far = far or step > limit or step < -limit
    return far


@kernel
def keep(k, place, words):
    """Store the words at `place`."""
    for n in range(np.int32(WORDS)):
        k[place + n] = words[n]


@kernel
def is_jump(k, words, saturated):
    """Whether this burst is to be refused; else it is kept as the one believed last.

    `saturated`: a rate is at the end of its range. No motion gets there in one step, so the burst before
    does not confirm it; once refused for long, all but its rates is believed."""
    seen = k[SEEN] != np.int64(0)
    far = seen and is_far(k, LAST, words, INERTIAL)
    confirmed = not saturated and k[REFUSALS] > np.int64(0) and not is_far(k, REFUSED, words, INERTIAL)
    no_rates = saturated and seen and is_far(k, LAST, words, RATES)
    k[RATES_ROW] = k[RATES_ROW] + np.int64(1) if no_rates else np.int64(0)
    if far and not confirmed and k[REFUSALS] < np.int64(MOST_REFUSED):
        keep(k, REFUSED, words)
        k[REFUSALS] += np.int64(1)
        k[JUMPS] += np.int64(1)
        return True
    if no_rates:
        for n in range(np.int32(RATES)):
            words[GYRO + n] = k[LAST + GYRO + n]
    else:
        k[REFUSALS] = np.int64(0)
    k[SEEN] = np.int64(1)
    keep(k, LAST, words)
    return False


@kernel
def count_still(k, words):
    """Follow for how long each triad has stood exactly as it is."""
    for triad in range(np.int32(3)):
        same = k[SEEN] != np.int64(0)
        for n in range(np.int32(3)):
            place = np.int64(GYRO + 3 * triad + n)
            same = same and signed_14(words[place]) == signed_14(k[LAST + place])
        k[STILL + triad] = k[STILL + triad] + np.int64(1) if same else np.int64(0)


@kernel
def is_gyro_frozen(k):
    """Whether rates stand for long although there is noise in them, and forces move."""
    stands = k[STILL] > FROZEN_READS and k[STILL + 1] < FROZEN_READS
    return stands and k[MOVES] > MOVES_OF_NOISE


@kernel
def hold_force(k, words):
    """Put the last force in the place of one at the end of its range."""
    beyond = False
    for n in range(np.int32(3)):
        force = signed_14(words[ACCEL + n])
        beyond = beyond or force >= FORCE_LIMIT or force <= -FORCE_LIMIT
    if beyond and k[SEEN] != np.int64(0):
        k[FORCES_HELD] += np.int64(1)
        for n in range(np.int32(3)):
            words[ACCEL + n] = k[LAST + ACCEL + n]
