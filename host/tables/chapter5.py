"""The conditions of the document's chapter 5, simulated in float64: what the filters of gfsins are fed.

A vehicle drives straight on at 80 km/h, heading 30°, level. Rate and specific force of the motion, with bias
and white noise on each sample of 200 Hz; compass 10 Hz with a Gauss-Markov error and white noise, in tenths
of a degree; GPS 1 Hz with white noise. A failure may be planted in compass or GPS.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.gyro_free.filters import Beginning
from host.sim.earth import EARTH_RATE, radii_and_gravity
from host.sim.seeding import generator

Array = NDArray[np.float64]
DEG = math.pi / 180.0
G = 9.80665
PERIOD_NS = 5_000_000
PERIOD = 0.005
LATITUDE, LONGITUDE, HEIGHT = 28.20021 * DEG, 112.92647 * DEG, 5.13145
SPEED, HEADING = 80.0 / 3.6, 30.0 * DEG
ATTITUDE_ERROR = (10.0 / 60.0 * DEG, 10.0 / 60.0 * DEG, 20.0 / 60.0 * DEG)
VELOCITY_ERROR, POSITION_ERROR = 0.02, 1.0
RATE_BIAS, RATE_NOISE = 0.1 * DEG, 0.02 * DEG
FORCE_BIAS, FORCE_NOISE = 5e-3 * G, 1e-3 * G
COMPASS_TIME = 300.0
COMPASS_ERROR = (0.03 * DEG, 0.04 * DEG, 0.1 * DEG)
COMPASS_START = (0.08 * DEG, 0.08 * DEG, 0.1 * DEG)
COMPASS_NOISE = (0.5 * DEG, 0.5 * DEG, 1.0 * DEG)
"""Of pitch, roll and heading each."""
GPS_NOISE, GPS_VELOCITY_NOISE = 10.0, 0.1
COMPASS_EVERY, GPS_EVERY = 20, 200
"""Samples."""


@dataclass(frozen=True, slots=True)
class Failure:
    """Something that goes wrong with one sensor from `start` to `end`, s."""

    sensor: str
    kind: str
    start: float = 200.0
    end: float = 260.0

    def holds(self, times: Array) -> NDArray[np.bool_]:
        """At which times."""
        return (times > self.start) & (times <= self.end)


@dataclass(frozen=True, slots=True)
class Feed:
    """All that reaches the kernels, and the truth once a second."""

    inertial: NDArray[np.float32]
    """(n, 6) rate and force; sample k is of (k + 1) · 5 ms."""
    compass: NDArray[np.int64]
    """(m, 3) heading, pitch, roll in tenths of a degree."""
    compass_told: NDArray[np.bool_]
    epochs: NDArray[np.int64]
    """(s, RECORD_SIZE)."""
    epochs_told: NDArray[np.bool_]
    start: Beginning
    truth: Array
    """(s, 3) latitude, longitude, height at full seconds; velocity and attitude stay the same."""


VELOCITY = np.array((SPEED * math.cos(HEADING), SPEED * math.sin(HEADING), 0.0))


def chapter5(duration_s: int, seed: int, failure: Failure | None = None) -> Feed:
    """One run of `duration_s` s."""
    places = _places(duration_s)
    compass, compass_told = _compass(duration_s, seed, failure)
    epochs, epochs_told = _gps(places, seed, failure)
    return Feed(_inertial(places, seed), compass, compass_told, epochs, epochs_told, _start(seed), places[1:])


def _places(duration_s: int) -> Array:
    """(duration + 1, 3) once a second, by steps of RK4 along constant velocity."""
    places = np.empty((duration_s + 1, 3))
    places[0] = LATITUDE, LONGITUDE, HEIGHT
    for k in range(duration_s):
        here = places[k]
        slopes = [_motion(here)]
        for part in (0.5, 0.5, 1.0):
            slopes.append(_motion(here + part * slopes[-1]))
        places[k + 1] = here + (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3]) / 6.0
    return places


def _motion(place: Array) -> Array:
    meridian, normal, _ = radii_and_gravity(math.sin(place[0]), place[2])
    return np.array((VELOCITY[0] / meridian, VELOCITY[1] / (normal * math.cos(place[0])), -VELOCITY[2]))


def _inertial(places: Array, seed: int) -> NDArray[np.float32]:
    count = (len(places) - 1) * GPS_EVERY
    seconds = np.arange(len(places), dtype=np.float64)
    times = PERIOD * np.arange(1, count + 1)
    exact = np.array([_felt(place) for place in places])
    felt = np.column_stack([np.interp(times, seconds, column) for column in exact.T])
    for axis in range(6):
        noise = generator(seed, f"inertial{axis}").standard_normal(count)
        felt[:, axis] += RATE_BIAS + RATE_NOISE * noise if axis < 3 else FORCE_BIAS + FORCE_NOISE * noise
    return felt.astype(np.float32)


def _felt(place: Array) -> Array:
    """ω_ib and f in body axes at a place."""
    latitude, _, height = place
    meridian, normal, gravity = radii_and_gravity(math.sin(latitude), height)
    earth = EARTH_RATE * np.array((math.cos(latitude), 0.0, -math.sin(latitude)))
    north, east, _ = VELOCITY
    transport = np.array((east / normal, -north / meridian, -east * math.tan(latitude) / normal))
    force = np.cross(2.0 * earth + transport, VELOCITY) - np.array((0.0, 0.0, gravity))
    c, s = math.cos(HEADING), math.sin(HEADING)
    to_body = np.array(((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)))
    return np.concatenate((to_body @ (earth + transport), to_body @ force))


def _compass(
    duration_s: int, seed: int, failure: Failure | None
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    count = duration_s * 10
    times = 0.1 * np.arange(1, count + 1, dtype=np.float64)
    decay = math.exp(-0.1 / COMPASS_TIME)
    angles = np.empty((count, 3))
    for axis, name in enumerate(("pitch", "roll", "heading")):
        drive = generator(seed, f"compass.{name}.error").standard_normal(count)
        error = COMPASS_START[axis] * generator(seed, f"compass.{name}.start").standard_normal()
        noise = generator(seed, f"compass.{name}.noise").standard_normal(count)
        for k in range(count):
            error = decay * error + COMPASS_ERROR[axis] * math.sqrt(1.0 - decay * decay) * drive[k]
            angles[k, axis] = error + COMPASS_NOISE[axis] * noise[k]
    angles[:, 2] += HEADING
    told = np.ones(count, np.bool_)
    if failure is not None and failure.sensor == "compass":
        _spoil_compass(angles, told, failure, failure.holds(times))
    tenths = np.round(np.degrees(angles) * 10.0).astype(np.int64)
    tenths[:, 2] %= 3600
    return np.ascontiguousarray(tenths[:, [2, 0, 1]]), told


def _spoil_compass(angles: Array, told: NDArray[np.bool_], failure: Failure, held: NDArray[np.bool_]) -> None:
    if failure.kind == "silent":
        told[held] = False
    elif failure.kind == "stuck":
        angles[held] = angles[held][0]
    else:
        angles[held, 2] += 25.0 * DEG


def _gps(places: Array, seed: int, failure: Failure | None) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    count = len(places) - 1
    noise = generator(seed, "gps").standard_normal((count, 6))
    epochs = np.zeros((count, gnss.RECORD_SIZE), np.int64)
    told = np.ones(count, np.bool_)
    offset = np.zeros(count)
    if failure is not None and failure.sensor == "gps":
        held = failure.holds(np.arange(1.0, count + 1.0))
        if failure.kind == "silent":
            told[held] = False
        else:
            offset[held] = 300.0
    for k in range(count):
        latitude, longitude, height = places[k + 1]
        meridian, normal, _ = radii_and_gravity(math.sin(latitude), height)
        north, east, down = GPS_NOISE * noise[k, :3]
        epoch = epochs[k]
        epoch[gnss.FLAGS] = gnss.HAS_POSITION | gnss.HAS_HEIGHT | gnss.HAS_VELOCITY
        epoch[gnss.LAT_NANODEG] = round(math.degrees(latitude + (north + offset[k]) / meridian) * 1e9)
        epoch[gnss.LON_NANODEG] = round(math.degrees(longitude + east / (normal * math.cos(latitude))) * 1e9)
        epoch[gnss.HEIGHT_MM] = round((height - down) * 1e3)
        velocity = VELOCITY + GPS_VELOCITY_NOISE * noise[k, 3:]
        epoch[[gnss.VEL_N_MMPS, gnss.VEL_E_MMPS, gnss.VEL_D_MMPS]] = np.round(velocity * 1e3)
        epoch[gnss.VALID_NS] = (k + 1) * GPS_EVERY * PERIOD_NS
    return epochs, told


def _start(seed: int) -> Beginning:
    """The truth with the document's initial errors; their signs are drawn."""
    signs = np.sign(generator(seed, "start").standard_normal(9))
    meridian, normal, _ = radii_and_gravity(math.sin(LATITUDE), HEIGHT)
    north, east, down = POSITION_ERROR * signs[:3]
    latitude = math.degrees(LATITUDE + north / meridian)
    longitude = math.degrees(LONGITUDE + east / (normal * math.cos(LATITUDE)))
    velocity = VELOCITY + VELOCITY_ERROR * signs[3:6]
    pitch, roll, yaw = np.array(ATTITUDE_ERROR) * signs[6:]
    return Beginning(
        0,
        round(latitude * 1e9),
        round(longitude * 1e9),
        HEIGHT - float(down),
        (float(velocity[0]), float(velocity[1]), float(velocity[2])),
        (HEADING + float(yaw), float(pitch), float(roll)),
    )
