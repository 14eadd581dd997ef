"""When the accelerometer says nothing about the vertical: an aircraft turns, climbs away or brakes.

In a turn without slip the specific force stands square to the wings whatever the bank is, so a filter that
levels by it would level the bank away; and it would do so for as long as the turn lasts. But the aircraft
then turns, and the force is longer than gravity: |f| = g / cos(bank). Along the path, too, acceleration makes
it longer. So force is withheld from the drift compensation while

    |ω̄| > 3 °/s    or    | |f|‾ − |f|₀ | > 0.1 m/s²

with means over TAU and |f|₀ as it was in the alignment, the accelerometer's own errors included. The gyros
carry the attitude meanwhile: their in-run bias of 0.007 °/s makes 0.4° in a minute.

Memory `g`, float: ω̄ (3), |f|‾, |f|₀, the force withheld (3), whether it is, what `disagreement` keeps
(3).
"""

import math
from typing import Final

import numpy as np

from firmware.nav.attitude import layout as at
from firmware.numerics.dialect import kernel

RATE: Final = 0
NORM: Final = 3
AT_REST: Final = 4
WITHHELD: Final = 5
IS_WITHHELD: Final = 8
CORRECTION: Final = 9
"""3 places, of `disagreement`."""
HOLDING_SIZE: Final = 12

TAU = np.float32(0.5)
"""s."""
RATE_LIMIT_SQUARE = np.float32((3.0 * math.pi / 180.0) ** 2)
NORM_LIMIT = np.float32(0.1)
LEAST_NORM = np.float32(1.0)
ZERO = np.float32(0.0)
ONE = np.float32(1.0)
NAN = np.float32(np.nan)


@kernel
def length(s, place):
    """Of three numbers."""
    x = s[place]
    y = s[place + 1]
    z = s[place + 2]
    return np.float32(math.sqrt(x * x + y * y + z * z))


@kernel
def begin(s, g):
    """The force of the alignment, or of now where there was none."""
    at_rest = length(s, at.SUM_FORCE) * s[at.PER_ALIGNMENT]
    if at_rest < LEAST_NORM:
        at_rest = length(s, at.FORCE + at.NEWEST)
    g[AT_REST] = at_rest
    g[NORM] = at_rest


@kernel
def withhold_force(s, g, regaining):
    """Take the newest force away where it says nothing about the vertical; `give_back` returns it.

    While the vertical is lost and being regained (`regaining`) a doubtful force is better than none."""
    if g[AT_REST] == ZERO:
        begin(s, g)
    share = s[at.PERIOD] / TAU
    square = ZERO
    for n in range(np.int32(3)):
        rate = s[at.OMEGA + at.NEWEST + n] - s[at.GYRO_BIAS + n]
        g[RATE + n] += share * (rate - g[RATE + n])
        square += g[RATE + n] * g[RATE + n]
    g[NORM] += share * (length(s, at.FORCE + at.NEWEST) - g[NORM])
    turns = square > RATE_LIMIT_SQUARE or abs(g[NORM] - g[AT_REST]) > NORM_LIMIT
    g[IS_WITHHELD] = ONE if turns and not regaining else ZERO
    if turns and not regaining:
        for n in range(np.int32(3)):
            g[WITHHELD + n] = s[at.FORCE + at.NEWEST + n]
            s[at.FORCE + at.NEWEST + n] = NAN


@kernel
def give_back(s, g):
    """The force again, which velocity needs."""
    if g[IS_WITHHELD] != ZERO:
        for n in range(np.int32(3)):
            s[at.FORCE + at.NEWEST + n] = g[WITHHELD + n]
