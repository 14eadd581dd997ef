"""Settings of the drift compensation as integers: done by the tools, before the filter runs."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.drift.fixed import bias
from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.bias import FIRST_VARIANCE
from firmware.nav.drift.fixed.heading import LARGEST_PACE
from firmware.nav.drift.settings import SATURATED_SHARE, DriftSettings
from firmware.numerics.fixed.angles import ONE_Q30, angle_of_radians
from firmware.numerics.fixed.arithmetic import LARGEST, in_q

SHORTEST_PERIOD, LONGEST_PERIOD = 5.0e-4, 0.03
FORCE_TAU, REST_TAU, FIELD_TAU, REFERENCE_TAU, HEADING_TAU = 3.0, 0.5, 0.05, 20.0, 5.0
ALIGNED_S = 2.0
TIMES_S = {
    at.REST_AFTER: 1.5,
    at.BELIEVED_AFTER: 0.5,
    at.LONGEST_REJECTION: 60.0,
    at.NEW_AFTER: 20.0,
    at.FIRST_AFTER: 5.0,
    at.PAUSE: 6.0,
    at.YOUNG: 0.3,
    at.UNLEVELLED_AGE: 0.3,
    at.LONGEST_MISSING: 0.4,
}
SAMPLE_Q = np.repeat([at.Q_RATE, at.Q_FORCE, at.Q_FIELD], 3)


def new_state(
    period: float, settings: DriftSettings | None = None
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Arrays (d, k) before the first sample; a sample comes every `period` s.

    ValueError when the period is out of range. `gyro_delay` is not supported: ValueError when there is one.
    """
    settings = settings or DriftSettings()
    if not SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        raise ValueError(
            f"period is {period!r} s; possible: {SHORTEST_PERIOD} … {LONGEST_PERIOD}, e.g. 0.004"
        )
    if settings.gyro_delay != 0.0:
        raise ValueError("gyro_delay is not known to the fixed-point filter; leave it at 0")
    d = np.zeros(at.D_SIZE, np.int32)
    k = np.zeros(at.K_SIZE, np.int64)
    d[[at.Q_NB, at.Q_FREE, at.Q_LEVEL]] = ONE_Q30
    d[at.BIAS_VARIANCE] = FIRST_VARIANCE
    k[[bias.XX, bias.YY, bias.ZZ]] = FIRST_VARIANCE << bias.VARIANCE_SHIFT
    d[at.HEADING_PACE] = LARGEST_PACE
    k[at.FINE_PACE] = LARGEST_PACE << (at.Q_FINE_PACE - at.Q_PACE)
    d[at.CANDIDATE_NORM] = -1
    d[at.PERIOD] = in_q(period, at.Q_PERIOD)
    d[at.PER_PERIOD] = in_q(1.0 / period, at.Q_PER_PERIOD)
    for place, tau in ((at.FORCE_GAIN, FORCE_TAU), (at.REST_GAIN, REST_TAU), (at.FIELD_GAIN, FIELD_TAU)):
        g = math.tan(period / (math.sqrt(2.0) * tau))
        d[place] = in_q(g, at.Q_GAIN)
        d[place + 1] = in_q(1.0 / (1.0 + math.sqrt(2.0) * g + g * g), 30)
    d[at.REFERENCE_SHARE] = in_q(1.0 - math.exp(-period / REFERENCE_TAU), 30)
    if settings.rate_range is not None:
        limit = SATURATED_SHARE * settings.rate_range * 2.0**at.Q_RATE
        d[at.RATE_LIMIT] = min(round(limit), LARGEST)
    d[at.DECLINATION] = angle_of_radians(settings.declination)
    for number, tau in enumerate((FORCE_TAU, REST_TAU, FIELD_TAU, HEADING_TAU)):
        k[at.SETTLED + number] = max(1, math.ceil(tau / period - 1e-9))
    k[at.ALIGNED_AGES] = k[at.ALIGNED_AGES + 1] = max(1, math.ceil(ALIGNED_S / period - 1e-9))
    for place, seconds in TIMES_S.items():
        k[place] = max(1, math.ceil(seconds / period - 1e-9))
    k[at.REJECTED_TIME] = 2 * k[at.LONGEST_REJECTION]
    return d, k


def samples(rows: NDArray[np.float64]) -> NDArray[np.int32]:
    """ω (rad/s), f (m/s²), m (T) in rows of 9 as `step` wants them.

    What is no number, or does not fit its format, becomes MISSING.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        numbers = np.rint(np.asarray(rows, np.float64) * 2.0**SAMPLE_Q)
        fits = np.abs(numbers) <= LARGEST
    return np.ascontiguousarray(np.where(fits, numbers, at.MISSING), np.int32)


def attitude(d: NDArray[Any]) -> NDArray[np.float64]:
    """q_nb."""
    return np.asarray(d[at.Q_NB : at.Q_NB + 4] / 2.0**at.Q_UNIT, np.float64)
