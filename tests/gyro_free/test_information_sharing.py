"""Fusion and sharing of information in UD form against covariances inverted in float64."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from firmware.nav import layout as at
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import steps
from firmware.nav.gyro_free.filters import FilterConfig, begin, new_federation
from firmware.nav.imu import imu_step
from host.tables.chapter5 import PERIOD, PERIOD_NS, chapter5

COMMON, ALL = 15, 18
FEED = chapter5(4, 3)


def covariance(f: np.ndarray) -> np.ndarray:
    """P (18, 18) in float64."""
    u = np.eye(ALL)
    for j in range(ALL):
        u[:j, j] = f[at.U + j * at.STATES : at.U + j * at.STATES + j]
    return u @ np.diag(f[at.D : at.D + ALL].astype(float)) @ u.T


def driven(reset: str, seconds: float):
    """A federation that is due for its fusion: compass and GPS taken, states apart."""
    config = FilterConfig(reset=reset)
    federation = new_federation(config)
    begin(federation, config, FEED.start)
    g, n = federation.g, federation.n
    samples = round(seconds / PERIOD)
    for k in range(samples):
        for f, i in (federation.compass, federation.gps, federation.master):
            imu_step(f, i, (k + 1) * PERIOD_NS, PERIOD, *FEED.inertial[k].tolist())
        if (k + 1) % 20 == 0:
            reading = FEED.compass[(k + 1) // 20 - 1].tolist()
            steps.compass_step(g, n, *federation.compass, *reading, (k + 1) * PERIOD_NS)
        if (k + 1) % 200 == 0:
            steps.gps_step(g, n, *federation.gps, FEED.epochs[(k + 1) // 200 - 1])
            if k + 1 < samples:
                steps.fusion_step(g, n, *federation.all)
    return federation


def difference(f: np.ndarray, i: np.ndarray, fm: np.ndarray, im: np.ndarray) -> np.ndarray:
    """x of one filter less x of another, 18 states; small angles."""
    d = np.zeros(ALL)
    d[0] = (i[at.LATITUDE] - im[at.LATITUDE]) * 2.0**-40 * fm[at.MERIDIAN_RADIUS]
    d[1] = (i[at.LONGITUDE] - im[at.LONGITUDE]) * 2.0**-40 * fm[at.PARALLEL_RADIUS]
    d[2] = float(fm[at.HEIGHT]) - float(f[at.HEIGHT])
    d[3:6] = f[at.VELOCITY : at.VELOCITY + 3].astype(float) - fm[at.VELOCITY : at.VELOCITY + 3]
    q, r = (Rotation.from_quat(one[[1, 2, 3, 0]].astype(float)) for one in (f, fm))
    d[6:9] = (q * r.inv()).as_rotvec()
    d[9:15] = f[9:15].astype(float) - fm[9:15]
    d[15:18] = f[15:18].astype(float) - fm[15:18]
    return d


def padded(information: np.ndarray) -> np.ndarray:
    whole = np.zeros((ALL, ALL))
    whole[:COMMON, :COMMON] = information
    return whole


def test_the_master_is_the_sum_of_informations() -> None:
    federation = driven("no_reset", 3.0)
    (f1, i1), (f2, i2) = federation.compass, federation.gps
    before = [one.copy() for one in (f1, i1, f2, i2)]
    steps.fusion_step(federation.g, federation.n, *federation.all)
    fm, im = federation.master
    # the filters were predicted first, in place, and not touched else
    p1, p2 = covariance(f1), covariance(f2)[:COMMON, :COMMON]
    information = np.linalg.inv(p1) + padded(np.linalg.inv(p2))
    expected = np.linalg.inv(information)
    found = covariance(fm)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.max(np.abs(found - expected) / scale) < 2e-3
    apart = difference(before[2], before[3], before[0], before[1])[:COMMON]
    mean = expected @ padded(np.linalg.inv(p2))[:, :COMMON] @ apart
    moved = difference(fm, im, before[0], before[1])
    assert np.max(np.abs(moved - mean) / np.sqrt(np.diag(expected))) < 0.02


@pytest.mark.parametrize(("reset", "share"), [("fusion_feedback", 0.5), ("proportional", 1 / 3)])
def test_shares_of_the_information_add_up_to_all_of_it(reset: str, share: float) -> None:
    federation = driven(reset, 3.0)
    compass = federation.n[gl.STATUS : gl.STATUS + 2]
    steps.fusion_step(federation.g, federation.n, *federation.all)
    assert not compass.any()
    p1 = covariance(federation.compass[0])
    parts = [np.linalg.inv(p1), padded(np.linalg.inv(covariance(federation.gps[0])[:COMMON, :COMMON]))]
    if reset == "proportional":
        parts.append(padded(np.linalg.inv(covariance(federation.master[0])[:COMMON, :COMMON])))
    whole = np.linalg.inv(sum(parts))
    common = whole[:COMMON, :COMMON]
    ratio = np.diag(p1)[:COMMON] / np.diag(common)
    assert ratio == pytest.approx(np.full(COMMON, 1 / share), rel=5e-3)
    # what is known of the compass's error once the common states are known is not shared
    given = [np.linalg.inv(np.linalg.inv(p)[COMMON:, COMMON:]) for p in (p1, whole)]
    assert np.diag(given[0]) == pytest.approx(np.diag(given[1]), rel=0.02)
    # and all filters stand where the master stands
    d = difference(*federation.gps, *federation.master)[:COMMON]
    assert np.max(np.abs(d) / np.sqrt(np.diag(common))) < 0.01


def test_a_zero_reset_leaves_all_to_the_master() -> None:
    federation = driven("zero_reset", 3.0)
    steps.fusion_step(federation.g, federation.n, *federation.all)
    p1, pm = covariance(federation.compass[0]), covariance(federation.master[0])
    assert np.all(np.diag(p1)[:COMMON] > 50 * np.diag(pm)[:COMMON])
    assert np.count_nonzero(p1 - np.diag(np.diag(p1))) == 0
