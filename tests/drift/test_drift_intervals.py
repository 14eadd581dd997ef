"""Intervals that no clock should tell, and long gaps: the filter keeps an attitude and finds back."""

import math

import numpy as np
import pytest
from hand_motion import HandMotion, errors_deg, hand_motion, rms

from firmware.nav.drift import layout as at
from firmware.nav.drift.settings import DriftSettings
from host.attitude.estimates import run_filter

GAP_BEGIN_S, GAP_S = 20.0, 30.0


def without(motion: HandMotion, begin_s: float, gap_s: float) -> tuple[HandMotion, int]:
    """The motion with its samples from `begin_s` on left out for `gap_s`, and where it goes on."""
    times = motion.dt * (1.0 + np.arange(len(motion.omega)))
    kept = (times <= begin_s) | (times > begin_s + gap_s)
    fields = (motion.omega, motion.omega_now, motion.force, motion.field)
    truth, place = motion.truth[kept], int(np.argmax(times > begin_s))
    return HandMotion(motion.dt, *[values[kept] for values in fields], truth, motion.moves[kept]), place


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_half_a_minute_without_samples_is_soon_got_over(seed):
    """One sample after a gap is one sample, not half a minute of them."""
    motion, place = without(hand_motion(seed=seed, moving_s=64.0), GAP_BEGIN_S, GAP_S)
    rows = motion.rows()
    rows[place, 0] = GAP_S + motion.dt
    quaternions, flags = run_filter(rows, DriftSettings())
    assert flags[place] & at.GAP
    errors = errors_deg(quaternions, motion)[place:]
    after = round(8.0 / motion.dt)
    assert rms(errors[after:]) < 5.0


@pytest.mark.parametrize("interval", [1e-45, 1e-30, 1e-9, 0.9, 30.0, 999.0])
def test_intervals_of_any_size_leave_numbers(interval):
    motion = hand_motion(moving_s=20.0, turn=10.0)
    rows = motion.rows()
    rows[2000:2010, 0] = interval
    quaternions, flags = run_filter(rows, DriftSettings(rate_range=60.0))
    assert np.isfinite(quaternions).all()
    assert np.allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-6)
    if interval < 1e-5:
        assert (flags[2000:2010] == 0).all()
        assert rms(errors_deg(quaternions, motion)[-1000:]) < 6.0  # ten samples of 25 rad/s were lost


def test_the_fastest_turn_over_the_longest_gap_is_not_turned():
    """200 rad/s for 1000 s: an angle that float32 has no sine of."""
    rows = hand_motion(moving_s=1.0).rows()
    rows[500, 0] = 1000.0
    rows[500, 1:4] = 190.0 / math.sqrt(3.0)
    quaternions, _ = run_filter(rows, DriftSettings())
    assert np.isfinite(quaternions).all()
