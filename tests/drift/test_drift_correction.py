"""The drift compensation behind the attitude loop: two samples an iteration, corrections after each."""

import math

import numpy as np
import pytest
from hand_motion import errors_deg, hand_motion, rms
from scipy.spatial.transform import Rotation

from firmware.nav.attitude import flags as noticed
from firmware.nav.attitude import layout as loop_at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.profiles import load_loop
from firmware.nav.drift import layout as at
from firmware.nav.drift.fixed.correction import correct as fixed_correct
from firmware.nav.drift.fixed.settings import new_state as fixed_state
from firmware.nav.drift.settings import DriftSettings, new_state
from firmware.numerics.precision import load
from host.attitude.estimates import run_filter

DEG = math.pi / 180.0
BIAS = np.array([0.5, -0.4, 0.3]) * DEG
RATE_HZ = 250.0
UNIT = {"float32": 1.0, "float64": 1.0, "fixed": 2.0**30}
"""Of a quaternion's components."""
LOST = 2000
"""The sample where one test loses some."""


def through_loop(motion, *, compensated=True, lost=0, profile="float32"):
    """(q_nb after each iteration, its sample, s, i, d, k)."""
    loop = load_loop(profile)
    config = AttitudeConfig(latitude=0.9, alignment_time=3.0, null_gyros=compensated)
    s, i, _ = loop.new_state(config)
    if profile == "fixed":
        d, k = fixed_state(2.0 / RATE_HZ, DriftSettings(rate_range=10.0))
        correct = fixed_correct
    else:
        d, k = new_state(DriftSettings(rate_range=10.0), loop.dtype)
        correct = load("firmware.nav.drift.correction", profile).correct
    rows = loop.samples(np.column_stack((motion.omega_now, motion.force, 1e-6 * motion.field)))
    attitudes, numbers = [], []
    for number, row in enumerate(rows):
        if LOST <= number < LOST + lost:
            loop.bridge(s, i)
        else:
            loop.take_rates(s, i, row)
        if not loop.iterate(s, i):
            continue
        if compensated:
            correct(s, i, d, k)
        attitudes.append(s[loop_at.QUATERNION : loop_at.QUATERNION + 4] / UNIT[profile])
        numbers.append(number)
    return np.array(attitudes), np.array(numbers), s, i, d, k


@pytest.fixture(scope="module")
def motion():
    return hand_motion(rate_hz=RATE_HZ, moving_s=22.0, turn=0.5).with_gyro(BIAS)


def errors_of(attitudes, numbers, motion, begin=0):
    """Errors of every sample in °, NaN where no iteration ended."""
    errors = np.full(len(motion.truth), np.nan)
    estimate = Rotation.from_quat(attitudes, scalar_first=True)
    errors[numbers] = np.degrees((estimate * motion.truth[numbers].inv()).magnitude())
    return errors[begin:]


@pytest.mark.parametrize("profile", ["float32", "float64", "fixed"])
def test_the_loop_no_longer_drifts(motion, profile):
    with_filter, numbers, s, *_ = through_loop(motion, profile=profile)
    without, _, _, *_ = through_loop(motion, compensated=False, profile=profile)
    held = errors_of(with_filter, numbers, motion, 4000)
    drifted = errors_of(without, numbers, motion, 4000)
    assert np.nanmax(held) < 1.5
    assert np.nanmax(drifted) > 3.0 * np.nanmax(held)
    bias = s[loop_at.GYRO_BIAS : loop_at.GYRO_BIAS + 3] / (2.0**27 if profile == "fixed" else 1.0)
    assert bias == pytest.approx(BIAS, abs=0.08 * DEG)


def test_it_waits_for_the_alignment():
    loop = load_loop("float32")
    s, i, _ = loop.new_state(AttitudeConfig())
    d, k = new_state()
    before = s.copy()
    assert load("firmware.nav.drift.correction", "float32").correct(s, i, d, k) == 0
    assert (s == before).all()
    assert k[at.SAMPLES] == 0
    assert i[loop_at.MODE] == noticed.ALIGNING


def test_lost_samples_are_bridged(motion):
    attitudes, numbers, _, i, _, k = through_loop(motion, lost=10)
    errors = errors_of(attitudes, numbers, motion)
    assert k[at.BAD_RATES] > 0
    assert i[loop_at.NOTICES + noticed.BRIDGED.bit_length() - 1] == 10
    assert np.nanmax(errors[LOST + 10 : LOST + 500]) < 4.0
    assert np.nanmax(errors[-500:]) < 2.5


def test_an_attitude_set_anew_is_taken_over(motion):
    loop = load_loop("float32")
    correct = load("firmware.nav.drift.correction", "float32").correct
    s, i, _ = loop.new_state(AttitudeConfig(latitude=0.9, alignment_time=3.0, null_gyros=True))
    d, k = new_state()
    rows = loop.samples(np.column_stack((motion.omega_now, motion.force, 1e-6 * motion.field)))
    q = loop_at.QUATERNION
    found = {}
    for number, row in enumerate(rows):
        loop.take_rates(s, i, row)
        if not loop.iterate(s, i):
            continue
        if number in (1200, 1201):
            w, x, y, z = s[q : q + 4].tolist()
            s[q : q + 4] = (-z, -y, x, w)  # half a turn about the vertical
        correct(s, i, d, k)
        truth = motion.truth[number]
        found[number] = np.degrees(
            (Rotation.from_quat(s[q : q + 4], scalar_first=True) * truth.inv()).magnitude()
        )
    assert found[max(n for n in found if n < 1200)] < 1.0
    assert found[min(n for n in found if n > 1201)] > 150.0
    assert found[max(found)] < 20.0


def test_direct_feed_and_the_loop_agree(motion):
    behind, numbers, *_ = through_loop(motion)
    direct, _ = run_filter(motion.rows(), DriftSettings(rate_range=10.0))
    late = numbers > 4000
    behind_the_loop = rms(errors_of(behind, numbers, motion)[numbers[late]])
    fed_directly = rms(errors_deg(direct, motion)[numbers[late]])
    assert behind_the_loop < fed_directly + 0.2
