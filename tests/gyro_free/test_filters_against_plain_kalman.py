"""The filters' covariance against a plain Kalman filter in float64, measurement by measurement."""

import math

import numpy as np
import pytest

from firmware.nav import layout as at
from firmware.nav.gyro_free.filters import FilterConfig, begin, new_federation
from firmware.nav.gyro_free.steps import compass_step, gps_step
from firmware.nav.imu import imu_step
from host.tables.chapter5 import HEADING, LATITUDE, PERIOD, PERIOD_NS, SPEED, chapter5

SECONDS, STATES, G = 25, 18, 9.7915
EARTH_RATE, RADIUS = 7.292115e-5, 6.37e6


def plain_covariance(config: FilterConfig, compass: bool, gps: bool) -> np.ndarray:
    """P after 25 s: r, v, φ, b_g, b_a, error of the compass; level, heading 30°, no acceleration."""
    c, s = math.cos(HEADING), math.sin(HEADING)
    to_n = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
    force = np.array((0.0, 0.0, -G))
    cross = np.array(((0, -force[2], force[1]), (force[2], 0, -force[0]), (-force[1], force[0], 0)))
    f = np.zeros((STATES, STATES))
    f[0:3, 3:6] = np.eye(3)
    f[3:6, 6:9] = -cross
    f[3:6, 12:15] = -to_n
    f[6:9, 9:12] = -to_n
    step = PERIOD
    f[15:, 15:] = -np.eye(3) / config.compass_time
    if gps:
        f[7, 8] = EARTH_RATE * math.cos(LATITUDE) + SPEED * s / RADIUS
        f[6, 8] = SPEED * c / RADIUS
    phi = np.eye(STATES) + f * step + f @ f * step**2 / 2
    tilt, heading = np.square(config.compass_error)
    driven = np.array((tilt, tilt, heading)) * 2 / config.compass_time
    noise = np.repeat((0, config.force_noise**2 * step, config.rate_noise**2 * step), 3)
    walks = np.repeat((config.rate_walk**2, config.force_walk**2), 3)
    q = np.diag(np.concatenate((noise, walks, driven))) * step
    sigmas = (config.sigma_position, config.sigma_velocity)
    angles = (config.sigma_tilt, config.sigma_tilt, config.sigma_yaw)
    biases = np.repeat((config.sigma_rate_bias, config.sigma_force_bias), 3)
    own = (config.sigma_compass[0], config.sigma_compass[0], config.sigma_compass[1])
    p = np.diag(np.square(np.concatenate((np.repeat(sigmas, 3), angles, biases, own))))
    h_compass = np.zeros((3, STATES))
    h_compass[:, 6:9] = h_compass[:, 15:18] = np.eye(3)
    h_gps = np.eye(6, STATES)
    r_compass = np.diag(np.square(config.compass_noise))
    r_gps = np.diag(np.square(np.repeat((config.position_noise[0], config.velocity_noise), 3)))
    for k in range(1, SECONDS * 200 + 1):
        p = phi @ p @ phi.T + q
        if compass and k % 20 == 0:
            p = updated(p, h_compass, r_compass)
        if gps and k % 200 == 0:
            p = updated(p, h_gps, r_gps)
    return p


def updated(p: np.ndarray, h: np.ndarray, r: np.ndarray) -> np.ndarray:
    gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
    rest = np.eye(STATES) - gain @ h
    return rest @ p @ rest.T + gain @ r @ gain.T


@pytest.mark.parametrize(("compass", "gps"), [(True, False), (False, True), (True, True)])
def test_sigmas_are_those_of_the_plain_filter(compass: bool, gps: bool) -> None:
    config = FilterConfig()
    federation = new_federation(config)
    feed = chapter5(SECONDS, 2)
    begin(federation, config, feed.start)
    f, i = federation.central
    for k, sample in enumerate(feed.inertial.tolist()):
        imu_step(f, i, (k + 1) * PERIOD_NS, PERIOD, *sample)
        if compass and (k + 1) % 20 == 0:
            heading, pitch, roll = feed.compass[(k + 1) // 20 - 1].tolist()
            compass_step(federation.g, federation.n, f, i, heading, pitch, roll, (k + 1) * PERIOD_NS)
        if gps and (k + 1) % 200 == 0:
            gps_step(federation.g, federation.n, f, i, feed.epochs[(k + 1) // 200 - 1])
    u = np.eye(STATES)
    for j in range(STATES):
        u[:j, j] = f[at.U + j * at.STATES : at.U + j * at.STATES + j]
    found = np.sqrt(np.diag(u @ np.diag(f[at.D : at.D + STATES].astype(float)) @ u.T))
    expected = np.sqrt(np.diag(plain_covariance(config, compass, gps)))
    if compass:
        assert found == pytest.approx(expected, rel=0.04)
    else:
        # heading acts on tilt once a second here, and makes tilt and bias less certain on purpose
        assert np.delete(found[:15], 8) == pytest.approx(np.delete(expected[:15], 8), rel=0.08)
        assert found[8] == pytest.approx(expected[8], rel=0.15)
