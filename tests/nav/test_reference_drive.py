"""Full combination on a drive through town: figures beside the receiver's own, and which states take part."""

import math

import numpy as np
import pytest
from nav_run import rms
from tactical_drive import ANTENNA, BASELINE, Drive, make_drive
from tactical_run import Result, run

from firmware.nav import layout as at
from firmware.nav.config import NavConfig
from firmware.nav.full_combination import full_combination

CHOSEN = {*range(at.X_MOUNTING), *range(at.X_GYRO_INSTABILITY, at.STATES)}
RECEIVER = set(range(at.X_GNSS_ERROR, at.X_MOUNTING))


def config(**choices: object) -> NavConfig:
    return full_combination(BASELINE, antenna_lever_arm=ANTENNA, **choices)


@pytest.fixture(scope="module")
def drive() -> Drive:
    return make_drive(1, duration_s=300.0)


@pytest.fixture(scope="module")
def result(drive: Drive) -> Result:
    return run(drive, config(), "float32")


def test_better_than_the_receiver_in_position_velocity_and_heading(drive: Drive, result: Result) -> None:
    ok = result.scored()
    assert np.sum(ok) > 200
    own = rms(drive.receiver_error[: len(ok)][ok, :2])
    assert rms(result.position[ok, :2]) < min(2.0, own)
    assert rms(result.velocity[ok]) < 0.05
    own_heading = rms(drive.heading_error[: len(ok)][ok])
    assert math.degrees(rms(result.attitude[ok, 2])) < min(0.08, math.degrees(own_heading))
    assert math.degrees(rms(result.attitude[ok, :2])) < 0.02
    assert 4.5 < np.mean(result.nees[ok]) < 18.0
    assert not result.seen("attitude_lost")[ok].any()


@pytest.mark.parametrize(("states", "count"), [("receiver", 21), ("document", 18)])
def test_states_not_chosen_stay_exactly_zero(drive: Drive, result: Result, states: str, count: int) -> None:
    """Neither variance nor estimate: the filter is one of 21, or 18, states."""
    one = result if states == "receiver" else run(drive, config(states="document"), "float32")
    d = one.f[at.D : at.D + at.STATES]
    chosen = CHOSEN if states == "receiver" else CHOSEN - RECEIVER
    assert len(chosen) == count
    assert set(np.flatnonzero(d)) == chosen
    parameters = one.f[at.GYRO_BIAS : at.GYRO_BIAS + at.PARAMETERS]
    assert set(np.flatnonzero(parameters) + at.X_GYRO_BIAS) <= chosen
    assert np.all(np.isfinite(one.f))


def test_other_states_are_refused() -> None:
    with pytest.raises(ValueError, match="states is 'all'; possible: receiver, document"):
        config(states="all")


def test_float32_stays_near_float64(drive: Drive, result: Result) -> None:
    wide = run(drive, config(), "float64")
    ok = result.scored(10.0)
    assert np.array_equal(wide.mode, result.mode)
    assert np.max(np.abs(wide.position - result.position)[ok]) < 0.3
    assert np.max(np.abs(wide.velocity - result.velocity)[ok]) < 0.01
    assert np.degrees(np.max(np.abs(wide.attitude - result.attitude)[ok])) < 0.02


@pytest.mark.soak
@pytest.mark.parametrize("standstill", [True, False])
def test_eight_drives_of_twenty_minutes(standstill: bool) -> None:
    """Every one better than its receiver; over all of them what the filter claims is what it is."""
    squares, nees = [], []
    for seed in range(1, 9):
        drive = make_drive(seed)
        one = run(drive, config(standstill=standstill))
        ok = one.scored()
        horizontal = rms(one.position[ok, :2])
        squares.append(horizontal**2)
        nees.append(np.mean(one.nees[ok]))
        assert horizontal < rms(drive.receiver_error[: len(ok)][ok, :2])
        assert rms(one.velocity[ok]) < 0.05
        assert math.degrees(rms(one.attitude[ok, 2])) < 0.08
    assert math.sqrt(np.mean(squares)) < 2.0
    assert 4.5 < np.mean(nees) < 18.0
