"""Scores of attitude filters against scipy's rotations; on real recordings the figures that are known."""

import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from scipy.spatial.transform import Rotation

from firmware.nav.drift.settings import DriftSettings
from host.attitude.comparison import compared, contenders
from host.attitude.estimates import by_drift_filter
from host.attitude.recording import AttitudeRecording, read_recording
from host.attitude.regaining import regaining
from host.attitude.register_feed import by_register_feed
from host.attitude.scoring import attitude_errors, east_north_up

DATA = os.environ.get("NAVTWIN_DATA")
TRIALS = Path(DATA or ".") / "broad"
VQF_TOTAL_DEG = {
    "02_undisturbed_slow_rotation_B": 1.38,
    "07_undisturbed_fast_rotation_B": 1.75,
    "16_undisturbed_fast_translation_B": 0.74,
    "30_disturbed_stationary_magnet_C": 2.57,
}
"""As vqf 2.1 gives them with its defaults, rounded."""
real = [
    pytest.mark.recording,
    pytest.mark.skipif(not TRIALS.is_dir(), reason="NAVTWIN_DATA names no folder with broad/"),
]
angle = some.floats(-math.pi, math.pi)
vector = some.tuples(angle, angle, angle)


@given(vector, vector)
def test_total_error_is_the_angle_between(first, second):
    a, b = Rotation.from_rotvec(first), Rotation.from_rotvec(second)
    errors = attitude_errors(a.as_quat(scalar_first=True)[None], b.as_quat(scalar_first=True)[None])
    assert errors.total[0] == pytest.approx(math.degrees((a * b.inv()).magnitude()), abs=1e-5)
    assert errors.heading[0] <= 180.0 + 1e-9
    assert errors.inclination[0] <= errors.total[0] + 1e-5


@given(vector, some.floats(-3.1, 3.1), some.floats(-1.5, 1.5), some.floats(0, 6.2))
def test_heading_and_inclination_are_the_parts(reference, heading, tilt, direction):
    """An error that turns about the vertical after tilting about a horizontal axis."""
    r = Rotation.from_rotvec(reference)
    tilted = Rotation.from_rotvec([tilt * math.cos(direction), tilt * math.sin(direction), 0.0])
    estimate = Rotation.from_rotvec([0, 0, heading]) * tilted * r
    errors = attitude_errors(estimate.as_quat(scalar_first=True)[None], r.as_quat(scalar_first=True)[None])
    assert errors.heading[0] == pytest.approx(abs(math.degrees(heading)), abs=1e-5)
    assert errors.inclination[0] == pytest.approx(abs(math.degrees(tilt)), abs=1e-5)


def test_only_movement_with_a_reference_counts():
    reference = np.tile([1.0, 0, 0, 0], (4, 1))
    reference[1] = np.nan
    turned = Rotation.from_rotvec([[0, 0, a] for a in (0.1, 0.2, 0.3, 0.4)]).as_quat(scalar_first=True)
    errors = attitude_errors(turned, reference)
    score = errors.rms(np.array([True, True, True, False]))
    assert score.total == pytest.approx(math.degrees(math.sqrt((0.01 + 0.09) / 2)))
    assert math.isnan(errors.rms(np.array([False, True, False, False])).total)


@given(vector)
def test_axes_of_the_earth(v):
    """North of one is the second axis of the other; down is the third, turned over."""
    q = Rotation.from_rotvec(v)
    enu = Rotation.from_quat(east_north_up(q.as_quat(scalar_first=True)[None])[0], scalar_first=True)
    north, east, down = q.as_matrix()
    assert enu.as_matrix() == pytest.approx(np.array([east, north, -down]), abs=1e-12)


def test_times_until_regained():
    saturated = np.zeros(100, bool)
    saturated[[10, 12, 50]] = True
    total = np.full(100, 1.0)
    total[10:20] = 8.0
    total[50:] = 9.0
    found = regaining(saturated, total, 0.1)
    assert (found.samples, found.episodes, found.regained) == (3, 2, 1)
    assert found.longest_s == pytest.approx(0.8)
    assert found.after_last_s is None
    assert regaining(np.zeros(100, bool), total, 0.1).episodes == 0


# -- real recordings -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def trials() -> list[AttitudeRecording]:
    return [read_recording(TRIALS / f"{name}.npz") for name in VQF_TOTAL_DEG]


def marked(function):
    for mark in real:
        function = mark(function)
    return function


@marked
def test_not_worse_than_vqf_and_vqf_as_published(trials):
    pytest.importorskip("vqf")
    *ours, theirs = contenders(["direct"], ["vqf"], DriftSettings(), ["float32", "fixed"])
    known = [compared(trial, theirs).score for trial in trials]
    assert [score.total for score in known] == pytest.approx(list(VQF_TOTAL_DEG.values()), abs=0.005)
    for contender in ours:
        for trial, theirs_one in zip(trials, known, strict=True):
            score = compared(trial, contender).score
            assert score.total <= theirs_one.total
            assert score.inclination <= theirs_one.inclination + 0.01


@marked
def test_through_the_bmi160_as_good_as_vqf_without_it(trials):
    for trial in trials:
        estimate = by_register_feed("bmi160", trial, DriftSettings())
        score = attitude_errors(estimate.quaternions, trial.reference).rms(trial.movement)
        assert score.total < VQF_TOTAL_DEG[trial.name] + 0.2
        assert not estimate.saturated.any()


def cut(trial, first_s, last_s):
    part = slice(round(first_s * trial.rate_hz), round(last_s * trial.rate_hz))
    arrays = ("omega", "force", "field", "reference", "movement")
    return replace(trial, **{name: getattr(trial, name)[part] for name in arrays})


@marked
def test_through_the_adis16407(trials):
    """Slow rotation, whose peaks reach beyond ±300 °/s."""
    slow = cut(trials[0], 20.0, 155.0)
    estimate = by_register_feed("adis16407", slow, DriftSettings())
    errors = attitude_errors(estimate.quaternions, slow.reference)
    assert errors.rms(slow.movement).total < 1.6
    beyond = np.abs(slow.omega).max(axis=1) > math.radians(303.0)
    near = np.convolve(estimate.saturated, np.ones(5), "same") > 0
    assert near[beyond].all()
    found = regaining(estimate.saturated, errors.total, slow.interval)
    assert found.samples >= 20
    assert found.regained == found.episodes
    assert found.after_last_s < 0.1


@marked
@pytest.mark.parametrize("begin", [1.0, 20.0])
def test_starts_and_rates_of_other_recordings(trials, begin):
    """Cut short, in other axes, with a bias of 1 °/s, every second sample."""
    turn = Rotation.from_rotvec([1.0, 0.7, -2.0])
    for trial in trials:
        first = round(begin * trial.rate_hz)
        n = (len(trial) - first) // 2 * 2
        part = slice(first, first + n)
        changed = AttitudeRecording(
            trial.name,
            trial.rate_hz / 2,
            turn.apply(trial.omega[part].reshape(-1, 2, 3).mean(axis=1) + math.radians(1.0)),
            turn.apply(trial.force[part][1::2]),
            turn.apply(trial.field[part][1::2]),
            (
                Rotation.from_quat(np.nan_to_num(trial.reference[part][1::2], nan=0.5), scalar_first=True)
                * turn.inv()
            ).as_quat(scalar_first=True),
            (trial.movement & np.isfinite(trial.reference).all(axis=1))[part][1::2],
        )
        estimate = by_drift_filter(changed, DriftSettings())
        score = attitude_errors(estimate.quaternions, changed.reference).rms(changed.movement)
        assert score.total < VQF_TOTAL_DEG[trial.name] + 0.3
