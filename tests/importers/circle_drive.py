"""A car on a circle, in closed form: what its IMU, its receiver and a reference would write down.

Level, constant speed: the body turns at speed / radius about down, feels speed² / radius towards the right
(the circle's middle) and gravity from below; the rotation of the Earth is left out of the rates on purpose:
15 °/h are less than what a MEMS gyro knows of itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

WEEK, START_SOW = 2300, 187_200.0
SPEED, RADIUS = 10.0, 80.0
LATITUDE, LONGITUDE, HEIGHT = 47.0, 8.5, 480.0
GRAVITY = 9.8067
DEGREES = 180.0 / np.pi
SEMI_MAJOR, E2 = 6_378_137.0, 6.69437999014e-3


@dataclass
class Circle:
    """Columns at instants `t` (s since the start)."""

    t: np.ndarray

    @property
    def yaw(self):
        return SPEED / RADIUS * self.t

    @property
    def place(self):
        """Latitude, longitude in °, height in m."""
        sine = np.sin(np.radians(LATITUDE))
        w2 = 1.0 - E2 * sine * sine
        transverse = SEMI_MAJOR / np.sqrt(w2)
        meridian = transverse * (1.0 - E2) / w2
        north, east = RADIUS * np.sin(self.yaw), RADIUS * (1.0 - np.cos(self.yaw))
        latitude = LATITUDE + north / (meridian + HEIGHT) * DEGREES
        longitude = LONGITUDE + east / ((transverse + HEIGHT) * np.cos(np.radians(LATITUDE))) * DEGREES
        return np.column_stack((latitude, longitude, np.full(len(self.t), HEIGHT)))

    @property
    def velocity(self):
        """North, east, down in m/s."""
        return np.column_stack((SPEED * np.cos(self.yaw), SPEED * np.sin(self.yaw), np.zeros(len(self.t))))

    @property
    def rate(self):
        """Forward, right, down in rad/s, with a sensor's noise."""
        clean = np.zeros((len(self.t), 3))
        clean[:, 2] = SPEED / RADIUS
        return clean + 1e-3 * np.random.default_rng(1).standard_normal(clean.shape)

    @property
    def force(self):
        """Forward, right, down in m/s², with a sensor's noise."""
        clean = np.zeros((len(self.t), 3))
        clean[:, 1] = SPEED * SPEED / RADIUS
        clean[:, 2] = -GRAVITY
        return clean + 2e-2 * np.random.default_rng(2).standard_normal(clean.shape)


def at_rate(rate_hz: float, duration_s: float = 90.0) -> Circle:
    """The drive, sampled steadily."""
    return Circle(np.arange(round(rate_hz * duration_s)) / rate_hz)


def write_kf_gins(folder, duration_s=90.0, rate_hz=100.0):
    """The three files, as KF-GINS has them: increments end at their time stamp."""
    middles = Circle((np.arange(round(rate_hz * duration_s)) + 0.5) / rate_hz)
    ends = START_SOW + (np.arange(len(middles.t)) + 1.0) / rate_hz
    np.savetxt(
        folder / "imu.txt", np.column_stack((ends, middles.rate / rate_hz, middles.force / rate_hz)), "%.10f"
    )
    slow = at_rate(1.0, duration_s)
    sigmas = np.full((len(slow.t), 3), (0.5, 0.6, 1.0))
    np.savetxt(folder / "gnss.txt", np.column_stack((START_SOW + slow.t, slow.place, sigmas)), "%.10f")
    fine = at_rate(10.0, duration_s)
    angles = np.column_stack((np.zeros((len(fine.t), 2)), np.degrees(fine.yaw) % 360.0))
    weeks = np.full(len(fine.t), WEEK)
    table = np.column_stack((weeks, START_SOW + fine.t, fine.place, fine.velocity, angles))
    np.savetxt(folder / "truth.nav", table, "%.10f")
    return [folder / name for name in ("imu.txt", "gnss.txt", "truth.nav")]
