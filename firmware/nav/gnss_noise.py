"""How good a GNSS epoch is: variances of its position and velocity, from the floor and the receiver's claims.

The receiver's error is modelled as white (layout row variance R) plus correlated (a state of the filter). A
claimed accuracy that exceeds both together adds its excess to R; one that is better is not believed, but R is
less for a receiver that was seen to scatter less (gnss_scatter). Without
a claim, the dilution of precision scales the error. Receivers filter: epochs closer together than
`epoch_independence` repeat one another's error, and the velocity's own delay is not that of the position (it
only matters while the latency is estimated).

Where the correlated error is no state (`position_error_states` off), an epoch is judged with it as it stands,
R + σ², but absorbed with as little weight as a white error of the same spectrum at low frequencies would
have, R + σ² 2T/Δt, Δt since the position absorbed before.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.history import seconds_between
from firmware.numerics.dialect import kernel

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
THIRD = np.float32(1.0 / 3.0)
ONE = np.float32(1.0)
MILLI = np.float32(1.0e-3)
CENTI = np.float32(1.0e-2)
SHORTEST = np.float32(0.02)
LONGEST_MM = np.int64(1_000_000)


@kernel
def position_variances(f, e):
    """Of each horizontal axis and of the vertical, m²."""
    white = f[cfg.POSITION_VARIANCE]
    correlated = f[cfg.POSITION_ERROR_VARIANCE_H]
    horizontal = _variance(
        white, correlated, e, HALF * _square_mm(e[gnss.H_ACC_MM]), e[gnss.HDOP_CENTI], f[cfg.PER_GOOD_HDOP]
    )
    white *= f[cfg.VERTICAL_FACTOR_SQUARE]
    correlated = f[cfg.POSITION_ERROR_VARIANCE_V]
    dop = e[gnss.VDOP_CENTI] if e[gnss.VDOP_CENTI] > 0 else e[gnss.HDOP_CENTI]
    vertical = _variance(white, correlated, e, _square_mm(e[gnss.V_ACC_MM]), dop, f[cfg.PER_GOOD_HDOP] * HALF)
    weight = f[at.EPOCH_WEIGHT]
    too_much = f[cfg.POSITION_VARIANCE] * (ONE - f[at.SCATTER_SHARE])
    horizontal -= too_much
    vertical -= too_much * f[cfg.VERTICAL_FACTOR_SQUARE]
    jitter = f[cfg.TIME_TAG_VARIANCE] * (_square(f, at.VELOCITY) + _square(f, at.VELOCITY + 1))
    return weight * horizontal + jitter, weight * vertical


@kernel
def _variance(white, correlated, e, claimed_square, dop_centi, per_good_dop):
    if e[gnss.FLAGS] & gnss.HAS_ACCURACY:
        return white + max(claimed_square - white - correlated, ZERO)
    scale = max(np.float32(np.int32(dop_centi)) * CENTI * per_good_dop, ONE)
    return scale * scale * (white + correlated) - correlated


@kernel
def _square_mm(value):
    metres = np.float32(np.int32(min(value, LONGEST_MM))) * MILLI
    return metres * metres


@kernel
def _square(f, place):
    return f[place] * f[place]


@kernel
def speed_variance(f, e):
    """Of each axis of a velocity, and of speed over ground, (m/s)²; the claim is of the whole vector."""
    variance = f[cfg.GNSS_VELOCITY_VARIANCE]
    if e[gnss.FLAGS] & gnss.HAS_ACCURACY:
        variance = max(variance, THIRD * _square_mm(e[gnss.S_ACC_MMPS]))
    a = at.AGO_ACCELERATION
    lag = f[cfg.VELOCITY_LAG_SQUARE] * (_square(f, a) + _square(f, a + 1) + _square(f, a + 2))
    return f[at.EPOCH_WEIGHT] * variance + lag


@kernel
def weigh_epoch(f, i, valid):
    """Errors of epochs that follow closely are the same errors: n within their time of change count as
    one."""
    spacing = max(seconds_between(i[at.FIX_TIME], valid), SHORTEST)
    f[at.EPOCH_WEIGHT] = max(f[cfg.EPOCH_INDEPENDENCE] / spacing, ONE)


@kernel
def add_lasting_error(f):
    """For the gate: the correlated error counts in full where no state holds it."""
    if f[cfg.POSITION_ERROR_WEIGHT] != ZERO:
        f[at.VARIANCE] += f[cfg.POSITION_ERROR_VARIANCE_H]
        f[at.VARIANCE + 1] += f[cfg.POSITION_ERROR_VARIANCE_H]
        f[at.VARIANCE + 2] += f[cfg.POSITION_ERROR_VARIANCE_V]


@kernel
def weigh_lasting_error(f, i, time):
    """For the update: the same error again and again tells less with each epoch."""
    if f[cfg.POSITION_ERROR_WEIGHT] != ZERO:
        spacing = max(seconds_between(i[at.POSITION_TIME], time), SHORTEST)
        more = max(f[cfg.POSITION_ERROR_WEIGHT] / spacing, ONE) - ONE
        f[at.VARIANCE] += more * f[cfg.POSITION_ERROR_VARIANCE_H]
        f[at.VARIANCE + 1] += more * f[cfg.POSITION_ERROR_VARIANCE_H]
        f[at.VARIANCE + 2] += more * f[cfg.POSITION_ERROR_VARIANCE_V]
        i[at.POSITION_TIME] = time
