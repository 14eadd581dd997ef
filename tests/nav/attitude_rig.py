"""Rides of the attitude computer: samples in closed form, and the loop driven over them."""

import importlib
import math
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.profiles import load_loop

Array = NDArray[np.float64]
DEG = math.pi / 180.0
PERIOD = 0.008
EARTH_RATE = 7.292115e-5
LATITUDE, LONGITUDE, HEIGHT = 47.0 * DEG, 11.0 * DEG, 800.0
FLIGHT_BEGIN = (0.4, 0.05, -0.1)
"""Yaw, pitch, roll."""
EVERY_PROFILE = ("float32", "fixed", "float64")


class Ride:
    """A loop in one arithmetic; `quaternions` and `records` after every `every`-th iteration."""

    def __init__(self, profile: str, config: AttitudeConfig) -> None:
        self.loop = load_loop(profile)
        self.s, self.i, self._out = self.loop.new_state(config)
        self.quaternions: list[Array] = []
        self.records: list[NDArray[np.int64]] = []

    def drive(self, samples: Array, every: int = 125) -> "Ride":
        """Rows of ω, f, m in SI every half iteration; the first is that of the beginning."""
        rows = self.loop.samples(samples)
        return self._drive(rows, self.loop.take_rates, every)

    def drive_words(self, bursts: NDArray[np.int64], every: int = 125) -> "Ride":
        """The same from rows of 14 words."""
        return self._drive(bursts, self.loop.take_words, every)

    def _drive(self, rows: Any, take: Any, every: int) -> "Ride":
        s, i, iterate = self.s, self.i, self.loop.iterate
        for row in rows:
            take(s, i, row)
            if iterate(s, i) and i[at.ITERATIONS] % every == 0:
                self.quaternions.append(self.quaternion())
                self.records.append(self.record())
        return self

    def quaternion(self) -> Array:
        q = self.s[at.QUATERNION : at.QUATERNION + 4].astype(np.float64)
        return q / np.linalg.norm(q)

    def record(self) -> NDArray[np.int64]:
        self.loop.solution(self.s, self.i, self._out)
        return self._out.copy()

    @property
    def angles_deg(self) -> Array:
        """Yaw, pitch, roll of the last solution."""
        return self.record()[:3] * 1e-9 / DEG


def angle_between_deg(a: Array, b: Array) -> Array:
    """Total rotation between rows of quaternions, in degrees."""
    a, b = np.atleast_2d(a), np.atleast_2d(b)
    w, v, p, u = a[:, :1], a[:, 1:], b[:, :1], b[:, 1:]
    return np.degrees(2.0 * np.linalg.norm(p * v - w * u + np.cross(u, v), axis=1))


def rotation(yaw: float, pitch: float, roll: float) -> Array:
    """C_n_b."""
    (cy, cp, cr), (sy, sp, sr) = ([f(a) for a in (yaw, pitch, roll)] for f in (math.cos, math.sin))
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    return about_z @ about_y @ about_x


def flight_angles(seconds: float) -> tuple[Array, Array, Array, Array]:
    """Times of the samples, yaw, pitch and roll of `flight`."""
    t = 0.5 * PERIOD * np.arange(2 * round(seconds / PERIOD) + 1)
    return (
        t,
        FLIGHT_BEGIN[0] + 0.05 * t + 0.3 * np.sin(0.2 * t),
        FLIGHT_BEGIN[1] + 0.2 * np.sin(0.31 * t) + 0.02 * np.sin(7.0 * t),
        FLIGHT_BEGIN[2] + 0.7 * np.sin(0.17 * t) + 0.03 * np.sin(11.0 * t),
    )


def flight_field(seconds: float) -> Array:
    """The Earth's field of `flight` in body axes with the sensor's noise, T."""
    _, yaw, pitch, roll = flight_angles(seconds)
    sy, cy, sp, cp, sr, cr = (f(a) for a in (yaw, pitch, roll) for f in (np.sin, np.cos))
    north, down = 2.0e-5, 4.0e-5
    ahead, right, below = cp * cy * north - sp * down, -sy * north, sp * cy * north + cp * down
    field = np.column_stack((ahead, cr * right + sr * below, cr * below - sr * right))
    return field + np.random.Generator(np.random.PCG64(8)).normal(0.0, 1.25e-7, field.shape)


def flight(seconds: float, noise: bool = False) -> Array:
    """A small aircraft that circles, banks to 40° and shakes: samples in SI, every half iteration.

    Rates are exact from FLIGHT_BEGIN on; forces are those of slow accelerations, gravity at LATITUDE and
    nothing for the turning Earth, so that the speed found drifts by metres a second. With noise, the
    sensor's.
    """
    t, yaw, pitch, roll = flight_angles(seconds)
    yaw_rate = 0.05 + 0.06 * np.cos(0.2 * t)
    pitch_rate = 0.062 * np.cos(0.31 * t) + 0.14 * np.cos(7.0 * t)
    roll_rate = 0.119 * np.cos(0.17 * t) + 0.33 * np.cos(11.0 * t)
    sp, cp, sr, cr = np.sin(pitch), np.cos(pitch), np.sin(roll), np.cos(roll)
    rates = np.column_stack(
        (
            roll_rate - yaw_rate * sp,
            pitch_rate * cr + yaw_rate * cp * sr,
            yaw_rate * cp * cr - pitch_rate * sr,
        )
    )
    north, east, down = 1.5 * np.sin(0.3 * t), np.cos(0.25 * t), 0.5 * np.sin(0.5 * t) - 9.8058
    ahead = np.cos(yaw) * north + np.sin(yaw) * east
    right = np.cos(yaw) * east - np.sin(yaw) * north
    below = sp * ahead + cp * down
    forces = np.column_stack((cp * ahead - sp * down, cr * right + sr * below, cr * below - sr * right))
    if noise:
        rng = np.random.Generator(np.random.PCG64(7))
        rates += rng.normal(0.0, 0.8 * DEG, rates.shape)
        forces += rng.normal(0.0, 0.09, forces.shape)
    return np.column_stack((rates, forces, np.tile([2.0e-5, 0.0, 4.0e-5], (len(t), 1))))


def bursts(samples: Array) -> NDArray[np.int64]:
    """The 14 words of each sample, written after the fact sheet: every register new, 5.00 V, 1000 mbar."""
    words = np.zeros((len(samples), 14), np.int64)
    words[:, 0] = 0x814
    words[:, 1:4] = np.rint(np.degrees(samples[:, 0:3]) / 0.05)
    words[:, 4:7] = np.rint(samples[:, 3:6] / 9.80665 * 300.0)
    words[:, 7:10] = np.rint(samples[:, 6:9] / 0.5e-7)
    words[:, 10] = 0x30D4
    return (words & 0x3FFF) | 0x8000


def at_rest(angles: tuple[float, float, float], count: int, declination: float = 0.0) -> Array:
    """Samples of a vehicle that stands at LATITUDE: Earth rate, gravity, and a field 64° down."""
    C_b_n = rotation(*angles).T
    omega = C_b_n @ (EARTH_RATE * np.array([math.cos(LATITUDE), 0.0, -math.sin(LATITUDE)]))
    force = C_b_n @ np.array([0.0, 0.0, -9.8065])
    field = 2.1e-5 * np.array([math.cos(declination), math.sin(declination), 2.05])
    return np.tile(np.concatenate((omega, force, C_b_n @ field)), (count, 1))


def earth_frame_oracle() -> ModuleType:
    """The mechanization in the Earth frame that also checks the simulator."""
    folder = str(Path(__file__).resolve().parents[1] / "sim")
    if folder not in sys.path:
        sys.path.append(folder)
    return importlib.import_module("ecef_mechanization")
