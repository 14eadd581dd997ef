"""Filters that break, sensors that stay wrong, samples that stop: every reset mode comes through."""

from collections.abc import Callable

import numpy as np
import pytest

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav.flags import NAVIGATING
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import steps
from firmware.nav.gyro_free.filters import Federation, FilterConfig, begin, new_federation
from firmware.nav.imu import imu_step
from host.tables.chapter5 import LATITUDE, PERIOD, PERIOD_NS, VELOCITY, chapter5

FEED = chapter5(60, 3)
EARTH = 6_371_000.0


def drive(
    reset: str,
    silent: tuple[int, int] = (0, 0),
    turned: int = 0,
    north_nanodeg: int = 0,
    spoil: Callable[[Federation], None] = lambda federation: None,
    rate_jump: float = 0.0,
) -> Federation:
    """60 s; from 20 s on the compass is off by `turned` tenths and GPS by `north_nanodeg`; `spoil` strikes at
    20 s; all is silent within `silent`."""
    config = FilterConfig(reset=reset, reopen_after=(150, 15))
    federation = new_federation(config)
    begin(federation, config, FEED.start)
    g, n = federation.g, federation.n
    for k, sample in enumerate(FEED.inertial.tolist()):
        t_ns, second = (k + 1) * PERIOD_NS, (k + 1) * PERIOD
        if silent[0] < second <= silent[1]:
            continue
        for f, i in (federation.compass, federation.gps, federation.master):
            imu_step(f, i, t_ns, PERIOD, sample[0], sample[1] + rate_jump * (second > 20.0), *sample[2:])
        wrong = second > 20.0
        if (k + 1) % 20 == 0:
            heading, pitch, roll = FEED.compass[(k + 1) // 20 - 1].tolist()
            heading = (heading + turned * wrong) % 3600
            steps.compass_step(g, n, *federation.compass, heading, pitch, roll, t_ns)
        if (k + 1) % 200 == 0:
            epoch = FEED.epochs[(k + 1) // 200 - 1].copy()
            epoch[gnss.LAT_NANODEG] += north_nanodeg * wrong
            steps.gps_step(g, n, *federation.gps, epoch)
            if second == 20.0:
                spoil(federation)
            steps.fusion_step(g, n, *federation.all)
    return federation


def errors(federation: Federation) -> tuple[float, float, float]:
    """North, m; speed, m/s; heading, rad."""
    f, i = federation.master
    north = (i[at.LATITUDE] * 2.0**-40 - FEED.truth[-1, 0]) * EARTH
    speed = np.linalg.norm(f[at.VELOCITY : at.VELOCITY + 3] - VELOCITY)
    w, x, y, z = f[:4].astype(float)
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return float(north), float(speed), float(yaw - np.radians(30.0))


def assert_well(federation: Federation) -> None:
    for f, i in (federation.compass, federation.gps, federation.master):
        assert i[at.MODE] == NAVIGATING
        assert np.all(np.isfinite(f[: at.ROWS]))
        assert np.all(f[at.D : at.D + 18] >= 0)
    north, speed, yaw = errors(federation)
    assert abs(north) < 30.0
    assert speed < 1.0
    assert abs(yaw) < np.radians(2.0)
    assert not federation.n[gl.STATUS : gl.STATUS + 2].any()


@pytest.mark.parametrize("which", ["compass", "gps", "master"])
@pytest.mark.parametrize("reset", gl.RESET_NAMES)
def test_a_filter_full_of_nan_is_rebuilt_from_the_others(reset: str, which: str) -> None:
    def spoil(federation: Federation) -> None:
        f, _ = getattr(federation, which)
        f[at.D + at.X_VELOCITY] = np.nan
        f[at.U + 8 * at.STATES] = np.inf

    federation = drive(reset, spoil=spoil)
    assert_well(federation)
    place = {"compass": gl.COMPASS, "gps": gl.GPS}.get(which)
    if place is not None:
        assert federation.n[gl.RECOVERIES + place] == 1


@pytest.mark.parametrize("reset", gl.RESET_NAMES)
def test_samples_that_stop_for_ten_seconds_are_got_over(reset: str) -> None:
    assert_well(drive(reset, silent=(20, 30)))


@pytest.mark.parametrize("reset", ["fusion_feedback", "zero_reset", "proportional"])
def test_a_sensor_that_stays_where_it_jumped_to_is_believed_in_the_end(reset: str) -> None:
    gps = drive(reset, north_nanodeg=9_000_000)
    assert gps.n[gl.ISOLATIONS + gl.GPS] >= 1
    assert gps.n[gl.REOPENED + gl.GPS] == 1
    assert errors(gps)[0] == pytest.approx(np.radians(9e-3) * EARTH, abs=60.0)
    compass = drive(reset, turned=300)
    assert compass.n[gl.ISOLATIONS + gl.COMPASS] >= 1
    assert compass.n[gl.REOPENED + gl.COMPASS] == 1
    assert errors(compass)[2] == pytest.approx(np.radians(30.0), abs=np.radians(3.0))


@pytest.mark.parametrize("reset", gl.RESET_NAMES)
def test_a_rate_that_jumps_by_6_degrees_per_second_is_found(reset: str) -> None:
    federation = drive(reset, rate_jump=0.1)
    assert_well(federation)
    assert federation.master[0][at.GYRO_BIAS + 1] == pytest.approx(0.1, abs=0.02)


def test_the_drive_is_where_chapter_5_is() -> None:
    assert FEED.truth[0, 0] == pytest.approx(LATITUDE, abs=1e-5)


@pytest.mark.parametrize("reset", gl.RESET_NAMES)
def test_doubt_grows_with_time_and_not_with_fusions(reset: str) -> None:
    """A second of contradiction by both sensors makes the master as uncertain in one fusion as in ten."""
    doubted = []
    for fusions in (1, 10):
        config = FilterConfig(reset=reset, fusion_period=1.0 / fusions)
        federation = new_federation(config)
        begin(federation, config, FEED.start)
        n, (f, _) = federation.n, federation.master
        n[gl.STATUS : gl.STATUS + 2] = gl.ISOLATED
        n[gl.ISOLATED_BY : gl.ISOLATED_BY + 2] = gl.CONTRADICTED
        before = f[at.D + at.X_POSITION]
        for _ in range(fusions):
            steps.fusion_step(federation.g, n, *federation.all)
        doubted.append(f[at.D + at.X_POSITION] - before)
    assert doubted[1] == pytest.approx(doubted[0], rel=0.01)
    assert doubted[0] > 1000.0
