"""Filters fused ten times a second know as much as one filter that gets all, whenever the compass comes."""

import numpy as np
import pytest

from firmware.nav import layout as at
from firmware.nav.gyro_free import steps
from firmware.nav.gyro_free.config import GyroFreeConfig
from firmware.nav.gyro_free.filters import adxl345_filters, begin, new_federation
from firmware.nav.imu import imu_step
from firmware.nav.prediction import predict_with_parameters
from host.tables.chapter5 import PERIOD, PERIOD_NS, chapter5

FEED = chapter5(25, 3)
STATES = {"attitude": at.X_ATTITUDE, "rate bias": at.X_GYRO_BIAS, "velocity": at.X_VELOCITY}


def uncertainty(ticks_behind_fusion: int) -> tuple[np.ndarray, np.ndarray]:
    """1 σ of the master and of the centralised filter after 25 s, of STATES about or along x, y, z."""
    config = adxl345_filters(GyroFreeConfig())
    federation = new_federation(config)
    begin(federation, config, FEED.start)
    g, n, central = federation.g, federation.n, federation.central
    fused_g, fused_n = g.copy(), n.copy()
    for k, sample in enumerate(FEED.inertial.tolist()):
        t_ns = (k + 1) * PERIOD_NS
        for f, i in (federation.compass, federation.gps, federation.master, central):
            imu_step(f, i, t_ns, PERIOD, *sample)
        if (k + 1) % 20 == ticks_behind_fusion:
            reading = FEED.compass[(k + 1) // 20 - 1].tolist()
            steps.compass_step(g, n, *federation.compass, *reading, t_ns)
            steps.compass_step(fused_g, fused_n, *central, *reading, t_ns)
        if (k + 1) % 200 == 0:
            epoch = FEED.epochs[(k + 1) // 200 - 1]
            steps.gps_step(g, n, *federation.gps, epoch)
            steps.gps_step(fused_g, fused_n, *central, epoch)
        if (k + 1) % 20 == 0:
            steps.fusion_step(g, n, *federation.all)
            predict_with_parameters(central[0])
    return sigmas(federation.master[0]), sigmas(central[0])


def sigmas(f: np.ndarray) -> np.ndarray:
    """Of STATES, from P = U D U'."""
    u = np.eye(at.STATES) + np.triu(f[at.U : at.U + at.STATES**2].reshape(at.STATES, at.STATES).T, 1)
    p = u @ np.diag(f[at.D : at.D + at.STATES]) @ u.T
    return np.sqrt([p[state + axis, state + axis] for state in STATES.values() for axis in range(3)])


@pytest.mark.parametrize("ticks", [0, 1, 10, 17])
def test_no_noise_is_lost_between_filters(ticks: int) -> None:
    federated, central = uncertainty(ticks)
    np.testing.assert_allclose(federated, central, rtol=0.1)
