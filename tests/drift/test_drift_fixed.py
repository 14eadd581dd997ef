"""The drift compensation in fixed point: against the truth and the float filter, saturation, formats."""

import math
import re

import numpy as np
import pytest
from hand_motion import errors_deg, hand_motion, rms
from scipy.spatial.transform import Rotation

from firmware.nav.drift import layout as float_at
from firmware.nav.drift.fixed import layout as at
from firmware.nav.drift.fixed.fusion import step
from firmware.nav.drift.fixed.settings import attitude, new_state, samples
from firmware.nav.drift.settings import DriftSettings
from host.attitude.estimates import run_filter

DEG = math.pi / 180.0
BIAS = np.array([1.0, -0.8, 0.6]) * DEG


def rows_of(motion):
    return np.column_stack((motion.omega, motion.force, 1e-6 * motion.field))


def filtered(rows, dt, settings=None):
    d, k = new_state(dt, settings)
    q = np.empty((len(rows), 4))
    flags = np.empty(len(rows), int)
    for number, sample in enumerate(samples(rows)):
        step(d, k, sample)
        q[number] = attitude(d)
        flags[number] = k[at.FLAGS]
    return q, flags, d, k


@pytest.fixture(scope="module")
def motion():
    return hand_motion().with_gyro(BIAS)


def test_as_good_as_float32(motion):
    q, _, d, k = filtered(rows_of(motion), motion.dt)
    in_float, _ = run_filter(motion.rows(), DriftSettings())
    ours, theirs = (rms(errors_deg(found, motion)[motion.moves]) for found in (q, in_float))
    assert ours < 1.15 * theirs + 0.05
    assert k[at.SATURATIONS] == 0
    assert d[at.GYRO_BIAS : at.GYRO_BIAS + 3] / 2.0**at.Q_BIAS == pytest.approx(BIAS, abs=0.05 * DEG)


@pytest.mark.parametrize("columns", [slice(0, 3), slice(3, 6), slice(6, 9), slice(0, 9)])
def test_no_numbers_are_bridged(motion, columns):
    rows = rows_of(motion)
    rows[4000:4010, columns] = math.nan
    q, flags, _, k = filtered(rows, motion.dt)
    missing = float_at.NO_RATE | float_at.NO_FORCE | float_at.FIELD_MISSING
    assert flags[4000] & missing
    assert not flags[4010] & missing
    assert errors_deg(q, motion)[4000:4400].max() < 6.0
    assert k[at.SATURATIONS] == 0


def test_one_missing_rate_is_no_reason_to_level_anew(motion):
    """Forces of motion would turn the attitude if levelling began again: as with float32, it does not."""
    rows = rows_of(motion)
    rows[2000::400, 0] = math.nan
    q, flags, _, k = filtered(rows, motion.dt)
    whole, _, _, _ = filtered(rows_of(motion), motion.dt)
    assert (flags[2000::400] & float_at.NO_RATE).all()
    assert k[float_at.BAD_RATES] == len(rows[2000::400])
    plain, missing = (rms(errors_deg(found, motion)[motion.moves]) for found in (whole, q))
    assert missing < plain + 0.3


def test_what_fits_no_format_is_missing(motion):
    rows = rows_of(motion)
    rows[3000:3010] *= 1e6
    q, flags, _, _ = filtered(rows, motion.dt)
    assert (flags[3000:3010] & float_at.NO_RATE).all()
    assert errors_deg(q, motion)[-400:].max() < 3.0


def test_the_ends_of_the_formats_saturate_and_are_counted(motion):
    d, k = new_state(motion.dt)
    good = samples(rows_of(motion))
    for sample in good[:1000]:
        step(d, k, sample)
    assert k[at.SATURATIONS] == 0
    for _ in range(50):
        step(d, k, np.full(9, 2**31 - 1, np.int32))
    assert k[at.SATURATIONS] > 50
    assert np.linalg.norm(attitude(d)) == pytest.approx(1.0, abs=1e-6)
    for sample in np.tile(good[100:1000], (8, 1)):
        step(d, k, sample)
    up = [0.0, 0.0, -1.0]
    turned = Rotation.from_quat(attitude(d), scalar_first=True).inv().apply(up)
    assert turned == pytest.approx(motion.truth[999].inv().apply(up), abs=0.05)


def test_any_integers_do_no_harm():
    rng = np.random.default_rng(3)
    d, k = new_state(0.004)
    for sample in rng.integers(-(2**31), 2**31, (2000, 9)).astype(np.int32):
        step(d, k, sample)
    assert np.linalg.norm(attitude(d)) == pytest.approx(1.0, abs=1e-6)


def test_saturated_rates_are_told(motion):
    limit = 3.0
    rows = rows_of(motion)
    rows[:, :3] = np.clip(rows[:, :3], -limit, limit)
    _, flags, _, k = filtered(rows, motion.dt, DriftSettings(rate_range=limit))
    beyond = np.abs(rows[:, :3]).max(axis=1) >= limit
    assert beyond.sum() > 100
    told = (flags & float_at.SATURATED) != 0
    assert told[beyond].all()
    assert not told[np.abs(rows[:, :3]).max(axis=1) < 0.99 * limit].any()
    assert k[at.SATURATED_SAMPLES] == told.sum()


@pytest.mark.parametrize("period", [0.0, 1e-4, 0.1, math.nan])
def test_periods_that_cannot_be(period):
    with pytest.raises(ValueError, match=re.escape(f"period is {period!r} s")):
        new_state(period)


def test_no_prediction_in_fixed_point():
    with pytest.raises(ValueError, match="gyro_delay is not known to the fixed-point filter"):
        new_state(0.004, DriftSettings(gyro_delay=0.001))


def test_samples_are_rows_in_memory():
    assert samples(np.asfortranarray(np.ones((50, 9)))).flags.c_contiguous
