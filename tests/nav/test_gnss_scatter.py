"""A receiver that scatters less than configured is followed more closely; one that scatters as configured is
weighted as before."""

import copy
import math

import numpy as np
import pytest
from nav_drive import Drive, make_drive
from nav_run import rms, run

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav.config import NavConfig

CONFIG = NavConfig(latency_sigma=0.0)
LATE_S = 100.0


def with_scatter(white_m: float) -> Drive:
    """Some minutes of town with so much white noise of position, and no other error of it."""
    overrides = (f"gnss.position_white_m={white_m}", "gnss.position_markov_m=0.0")
    return make_drive("town-open", 1, duration_s=400.0, overrides=overrides)


@pytest.mark.parametrize("white_m", [0.02, 0.1])
def test_scatter_is_learnt(white_m: float) -> None:
    result = run(with_scatter(white_m), CONFIG)
    assert math.sqrt(result.f[at.SCATTER]) == pytest.approx(white_m, abs=0.04)


def test_smooth_receiver_is_followed_closely() -> None:
    """Two centimetres of noise: over ten seconds the error changes less than as configured, 0.16 m.

    What it is as a whole is the slow part of the error, which the configuration still expects.
    """
    result = run(with_scatter(0.02), CONFIG)
    error = result.position[result.t > LATE_S, :2]
    assert rms(error[100:] - error[:-100]) < 0.145


def test_receiver_as_configured_is_weighted_as_configured() -> None:
    """With the noise of the configuration the variance in use stays the configured one."""
    drive = make_drive("town-open", 1, duration_s=400.0)
    result = run(drive, CONFIG)
    assert 4.0 * result.f[at.SCATTER] > CONFIG.position_noise**2
    assert math.sqrt(result.f[at.SCATTER]) == pytest.approx(0.5, rel=0.4)


def test_step_of_a_smooth_receiver_is_taken_over() -> None:
    """Half a metre at once, as by other satellites: followed within half a minute, not realigned."""
    drive = with_scatter(0.02)
    moved = copy.copy(drive)
    moved.epochs = [(t, e.copy()) for t, e in drive.epochs]
    step_s = 150.0
    for t, epoch in moved.epochs:
        if t > step_s * 1e9:
            epoch[gnss.LAT_NANODEG] += round(math.degrees(0.5 / 6.37e6) * 1e9)
    plain, stepped = run(drive, CONFIG), run(moved, CONFIG)
    late = plain.t > step_s + 30.0
    difference = stepped.position[late, 0] - plain.position[late, 0]
    assert np.max(np.abs(difference - 0.5)) < 0.25
    assert not np.any(stepped.seen("realigned"))
    assert np.max(np.linalg.norm(stepped.velocity[late], axis=1)) < 0.3
