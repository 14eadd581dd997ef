"""The drift compensation on simulated motion: against the truth, against vqf, and with what breaks."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from hand_motion import FIELD_NED, G, HandMotion, errors_deg, hand_motion, rms
from scipy import signal
from scipy.spatial.transform import Rotation

from firmware.nav.drift import layout as at
from firmware.nav.drift.fusion import step
from firmware.nav.drift.settings import DriftSettings, new_state
from host.attitude.estimates import run_filter

DEG = math.pi / 180.0
BIAS = np.array([1.0, -0.8, 0.6]) * DEG
TO_ENU = Rotation.from_quat([0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0], scalar_first=True)


@functools.cache
def plain() -> HandMotion:
    return hand_motion()


def filtered(motion, settings=None, arithmetic="float32"):
    return run_filter(motion.rows(), settings or DriftSettings(), arithmetic)


def states(rows, settings=None):
    d, k = new_state(settings)
    for row in np.ascontiguousarray(rows, np.float32):
        step(d, k, row)
    return d, k


def by_vqf(motion):
    vqf = pytest.importorskip("vqf")
    arrays = [np.ascontiguousarray(values) for values in (motion.omega, motion.force, motion.field)]
    q_enu = Rotation.from_quat(vqf.VQF(motion.dt).updateBatch(*arrays)["quat9D"], scalar_first=True)
    return (TO_ENU.inv() * q_enu).as_quat(scalar_first=True)


def test_attitude_of_a_hand_is_within_a_degree():
    errors = errors_deg(filtered(plain())[0], plain())
    assert rms(errors[plain().moves]) < 0.6
    assert errors[plain().moves].max() < 2.0


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"seed": 2, "turn": 4.0},
        {"seed": 3, "shake": 6.0},
        {"seed": 4, "rate_hz": 60.0},
        {"seed": 5, "turn": 0.3, "shake": 0.5},
    ],
)
def test_not_worse_than_vqf(change):
    motion = hand_motion(**change).with_gyro(BIAS)
    ours = rms(errors_deg(filtered(motion)[0], motion)[motion.moves])
    theirs = rms(errors_deg(by_vqf(motion), motion)[motion.moves])
    assert ours < 1.1 * theirs + 0.02


def test_float32_loses_nothing():
    narrow, wide = filtered(plain())[0], filtered(plain(), arithmetic="float64")[0]
    between = (
        Rotation.from_quat(narrow, scalar_first=True) * Rotation.from_quat(wide, scalar_first=True).inv()
    )
    assert np.degrees(between.magnitude()).max() < 0.01


@pytest.mark.parametrize(
    "first",
    [Rotation.from_rotvec(v) for v in ([math.pi, 0, 0], [0, 1.57, 0], [0, -1.5, 2.0], [3.0, 0.4, -1.0])],
)
def test_from_any_attitude(first):
    motion = hand_motion(first=first, rest_s=4.0, moving_s=4.0)
    errors = errors_deg(filtered(motion)[0], motion)
    assert errors[100] < 1.5
    assert errors[motion.moves].max() < 3.0


def test_bias_at_rest_is_known_after_ten_seconds():
    motion = hand_motion(rest_s=10.0, moving_s=0.0).with_gyro(BIAS)
    d, k = states(motion.rows())
    assert d[at.GYRO_BIAS : at.GYRO_BIAS + 3] == pytest.approx(BIAS, abs=0.02 * DEG)
    assert k[at.FLAGS] & at.AT_REST


def test_bias_is_learnt_in_motion_without_any_rest():
    motion = hand_motion(rest_s=0.0, moving_s=90.0, turn=0.5).with_gyro(0.5 * BIAS)
    d, k = states(motion.rows())
    assert d[at.GYRO_BIAS : at.GYRO_BIAS + 3] == pytest.approx(0.5 * BIAS, abs=0.12 * DEG)
    assert not k[at.FLAGS] & at.AT_REST


def disturbed(motion, field_ned, first, last):
    """The field of a magnet that stays where it is, on top of the Earth's for a while."""
    t = np.arange(len(motion.omega)) * motion.dt
    near = ((t >= first) & (t < last))[:, None]
    return replace(
        motion, field=motion.field + near * motion.truth.inv().apply(np.tile(field_ned, (len(t), 1)))
    )


def test_a_magnet_is_rejected_and_told():
    motion = disturbed(hand_motion(moving_s=44.0), (0.0, 30.0, 0.0), 25.0, 40.0)
    q, flags = filtered(motion)
    t = np.arange(len(q)) * motion.dt
    magnet = (t > 25.5) & (t < 40.0)
    assert ((flags[magnet] & at.FIELD_DISTURBED) != 0).mean() > 0.99
    assert errors_deg(q, motion)[t > 25.0].max() < 3.0
    assert ((flags[t > 42.0] & at.FIELD_DISTURBED) == 0).all()


def test_a_weak_disturbance_turns_it_less_than_vqf():
    motion = disturbed(hand_motion(moving_s=44.0), (0.0, 3.0, 3.0), 20.0, 50.0)
    ours, theirs = (errors_deg(q, motion)[motion.moves] for q in (filtered(motion)[0], by_vqf(motion)))
    assert rms(ours) < rms(theirs)


def test_another_field_that_stays_is_taken_for_the_new_one():
    motion = disturbed(hand_motion(moving_s=94.0), (0.0, 20.0, 20.0), 30.0, 200.0)
    q, flags = filtered(motion)
    t = np.arange(len(q)) * motion.dt
    assert ((flags[t > 70.0] & at.FIELD_DISTURBED) == 0).mean() > 0.9


@pytest.mark.parametrize("nothing", [0.0, math.nan])
def test_without_a_magnetometer_it_levels(nothing):
    motion = replace(plain(), field=np.full_like(plain().field, nothing))
    q, flags = filtered(motion)
    up = Rotation.from_quat(q, scalar_first=True).inv().apply([0, 0, -1.0])
    true_up = motion.truth.inv().apply([0, 0, -1.0])
    tilt = np.degrees(np.arccos(np.clip((up * true_up).sum(axis=1), -1, 1)))
    assert rms(tilt[motion.moves]) < 0.6
    assert ((flags & at.FIELD_MISSING) != 0).all()


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 3.0e38])
@pytest.mark.parametrize("columns", [slice(1, 4), slice(4, 7), slice(7, 10), slice(1, 10)])
def test_no_numbers_are_bridged(bad, columns):
    rows = plain().rows()
    begin = 4000
    rows[begin : begin + 10, columns] = bad
    q, flags = run_filter(rows, DriftSettings())
    errors = errors_deg(q, plain())
    assert np.isfinite(q).all()
    assert np.linalg.norm(q, axis=1) == pytest.approx(1.0, abs=1e-5)
    assert errors[begin : begin + 400].max() < 4.0
    assert flags[begin] & (at.NO_RATE | at.NO_FORCE | at.FIELD_MISSING)
    assert not flags[begin + 10] & (at.NO_RATE | at.NO_FORCE | at.FIELD_MISSING)


def test_nothing_but_nonsense_does_no_harm():
    rng = np.random.default_rng(7)
    rows = rng.normal(0, 1, (3000, 10)) * 10.0 ** rng.integers(-30, 30, (3000, 10))
    rows[rng.random(rows.shape) < 0.1] = math.nan
    q, _ = run_filter(np.vstack((rows, plain().rows())), DriftSettings())
    assert np.isfinite(q).all()
    assert errors_deg(q[3000:], plain())[-1000:].max() < 6.0


@pytest.mark.parametrize("interval", [0.0, -1.0, math.nan, math.inf])
def test_an_interval_that_cannot_be_is_left_out(interval):
    rows = plain().rows()
    spoilt = np.insert(rows, 5000, rows[5000], axis=0)
    spoilt[5000, 0] = interval
    q, _ = run_filter(spoilt, DriftSettings())
    good, _ = run_filter(rows, DriftSettings())
    assert (q[-1] == good[-1]).all()
    _, k = states(spoilt[4990:5010])
    assert k[at.BAD_INTERVALS] == 1


def test_missing_samples_are_a_gap():
    rows = plain().rows()
    kept = np.delete(rows, np.arange(4000, 4012), axis=0)
    kept[4000, 0] = 13 * plain().dt
    q, flags = run_filter(kept, DriftSettings())
    left = replace(plain(), truth=plain().truth[np.delete(np.arange(len(rows)), np.arange(4000, 4012))])
    assert flags[4000] & at.GAP
    assert errors_deg(q, left)[4000:4400].max() < 5.0
    assert errors_deg(q, left)[-400:].max() < 2.0


def test_uneven_intervals():
    """Every third sample is missing, the interval says so."""
    rows = plain().rows()
    kept = np.arange(len(rows)) % 3 != 2
    pairs = rows[:, 1:4].copy()
    pairs[3::3] = 0.5 * (rows[3::3, 1:4] + rows[2:-1:3, 1:4][: len(pairs[3::3])])
    rows[:, 1:4] = pairs
    rows[3::3, 0] *= 2.0
    motion = replace(plain(), truth=plain().truth[kept])
    errors = errors_deg(run_filter(rows[kept], DriftSettings())[0], motion)
    assert rms(errors[plain().moves[kept]]) < 0.7


def test_saturation_is_flagged_bridged_and_got_over():
    limit = 3.5
    motion = hand_motion(seed=4, turn=2.0, calm_s=8.0)
    clipped = replace(motion, omega=np.clip(motion.omega, -limit, limit))
    aware, flags = filtered(clipped, DriftSettings(rate_range=limit))
    unaware, _ = filtered(clipped)
    beyond = (np.abs(motion.omega) >= limit).any(axis=1)
    assert beyond.sum() > 100
    assert ((flags & at.SATURATED) != 0)[np.abs(clipped.omega).max(axis=1) >= limit].all()
    assert ((flags & at.SATURATED) == 0)[np.abs(clipped.omega).max(axis=1) < 0.99 * limit].all()
    last = np.flatnonzero(beyond)[-1]
    after = errors_deg(aware, motion)[last:]
    assert rms(errors_deg(aware, motion)[motion.moves]) < 0.5 * rms(errors_deg(unaware, motion)[motion.moves])
    assert (after < 5.0).any()


def test_gyro_delay_is_predicted_away():
    late = replace(plain(), omega=np.vstack((plain().omega[:1], plain().omega[:-1])))
    without, ahead = (
        rms(errors_deg(filtered(late, s)[0], plain())[plain().moves])
        for s in (DriftSettings(), DriftSettings(gyro_delay=plain().dt))
    )
    assert ahead < 0.8 * without


def test_declination_turns_the_heading():
    east = filtered(plain(), DriftSettings(declination=10 * DEG))[0]
    turned = replace(plain(), truth=Rotation.from_rotvec([0, 0, 10 * DEG]) * plain().truth)
    assert rms(errors_deg(east, turned)[plain().moves]) < 0.6


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate_range": 0.0}, "rate_range is 0.0 rad/s"),
        ({"rate_range": math.nan}, "rate_range is nan"),
        ({"declination": 4.0}, "declination is 4.0 rad"),
        ({"gyro_delay": -0.1}, "gyro_delay is -0.1 s"),
    ],
)
def test_settings_that_cannot_be(change, message):
    with pytest.raises(ValueError, match=message):
        DriftSettings(**change)


def test_smoothing_is_the_butterworth_filter():
    """Levelling by one force that jumps: scipy's filter in float64 is the oracle, τ = 3 s at 285.7 Hz."""
    dt, tau, n = 0.0035, 3.0, 6000
    b, a = signal.butter(2, math.sqrt(2) / (2 * math.pi * tau), fs=1 / dt)
    start = math.ceil(tau / dt)
    force = np.tile([0.0, 0.0, -G], (n, 1))
    force[3000:, 0] = 0.5
    state = signal.lfilter_zi(b, a)
    smoothed = signal.lfilter(b, a, force[start:, 0], zi=state * 0.0)[0]
    rows = np.column_stack((np.full(n, dt), np.zeros((n, 3)), force, np.tile(FIELD_NED, (n, 1))))
    d, k = new_state()
    tilts = []
    for row in np.ascontiguousarray(rows, np.float32):
        step(d, k, row)
        w, _, y, _ = d[at.Q_LEVEL : at.Q_LEVEL + 4].astype(float)
        tilts.append(2 * math.atan2(y, w))
    assert np.array(tilts[start:]) == pytest.approx(np.arctan2(smoothed, G), abs=2e-6)
