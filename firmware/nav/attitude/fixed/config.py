"""The configuration of the attitude computer as integers: done by the tools, before the loop runs."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude.config import AttitudeConfig, configure_integers, initial_values
from firmware.nav.attitude.fixed import layout as at
from firmware.numerics.fixed.angles import angle_of_radians
from firmware.numerics.fixed.arithmetic import LARGEST, SMALLEST, in_q

SAMPLE_Q = np.repeat([at.Q_RATE, at.Q_FORCE, at.Q_FIELD], 3)
BITS = {place + k: bits for place, count, bits in at.FORMATS for k in range(count)}


def configure(s: NDArray[Any], i: NDArray[np.int64], config: AttitudeConfig) -> None:
    """Set the arrays of the fixed-point loop. ValueError when a number does not fit its format."""
    configure_integers(i, config)
    s[:] = 0
    values = initial_values(config)
    values[at.HALF_PERIOD] = (0.5 * config.period,)
    values[at.SIXTH_PERIOD] = (config.period / 6.0,)
    values[at.TURN_PERIOD] = (0.5 * config.period * 2.0 ** (32 - at.Q_RATE) / (2.0 * math.pi),)
    for place, numbers in values.items():
        for k, value in enumerate(numbers, start=place):
            if k in BITS:
                s[k] = in_q(value, BITS[k])
            elif k in (at.DECLINATION, at.GIVEN_YAW):
                s[k] = angle_of_radians(value)


def samples(rows: NDArray[np.float64]) -> NDArray[np.int32]:
    """ω (rad/s), f (m/s²), m (T) in rows of 9 as `take_rates` wants them; clipped to the formats."""
    numbers = np.rint(np.asarray(rows, np.float64) * 2.0**SAMPLE_Q)
    return np.clip(numbers, SMALLEST, LARGEST).astype(np.int32)
