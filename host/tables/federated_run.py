"""Filters of gfsins on the conditions of chapter 5: their errors against the truth, once a second."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav import layout as at
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import steps
from firmware.nav.gyro_free.filters import FilterConfig, begin, new_federation
from firmware.nav.imu import imu_step
from firmware.numerics.dialect import entry_point
from host.sim.earth import radii_and_gravity
from host.tables.chapter5 import COMPASS_EVERY, GPS_EVERY, HEADING, PERIOD, PERIOD_NS, VELOCITY, Feed

Array = NDArray[np.float64]
UNIT = 2.0**-40


@dataclass(frozen=True, slots=True)
class Errors:
    """Estimate less truth once a second, and what the filter itself believes (1 σ)."""

    position: Array
    """(s, 3) NED, m."""
    velocity: Array
    attitude: Array
    """(s, 3) roll, pitch, yaw, rad."""
    yaw_sigma: Array
    """(s,) of φ down."""


@dataclass(frozen=True, slots=True)
class FederatedErrors:
    """One run of the federation."""

    master: Errors
    isolated: NDArray[np.bool_]
    """(s, 2) compass filter and GPS filter."""
    cause: NDArray[np.int64]
    recoveries: tuple[int, int]


def run_single(feed: Feed, config: FilterConfig, compass: bool, gps: bool) -> Errors:
    """One filter by itself, with compass (18 states), GPS or both."""
    federation = new_federation(config)
    begin(federation, config, feed.start)
    g, n = federation.g, federation.n
    f, i = federation.central
    move = entry_point(imu_step)
    take_compass, take_gps = entry_point(steps.compass_step), entry_point(steps.gps_step)
    course = _Course(feed)
    for k, sample in enumerate(feed.inertial.tolist()):
        t_ns = (k + 1) * PERIOD_NS
        move(f, i, t_ns, PERIOD, *sample)
        if (k + 1) % COMPASS_EVERY == 0:
            place = (k + 1) // COMPASS_EVERY - 1
            if compass and feed.compass_told[place]:
                heading, pitch, roll = feed.compass[place].tolist()
                take_compass(g, n, f, i, heading, pitch, roll, t_ns)
        if (k + 1) % GPS_EVERY == 0:
            place = (k + 1) // GPS_EVERY - 1
            if gps and feed.epochs_told[place]:
                take_gps(g, n, f, i, feed.epochs[place])
            course.note(place, f, i)
    return course.errors()


def run_federated(feed: Feed, config: FilterConfig) -> FederatedErrors:
    """Compass filter, GPS filter and master."""
    federation = new_federation(config)
    begin(federation, config, feed.start)
    g, n = federation.g, federation.n
    move = entry_point(imu_step)
    take_compass, take_gps = entry_point(steps.compass_step), entry_point(steps.gps_step)
    fuse = entry_point(steps.fusion_step)
    course = _Course(feed)
    isolated = np.zeros((len(feed.truth), 2), np.bool_)
    cause = np.zeros((len(feed.truth), 2), np.int64)
    arrays = federation.all
    filters = federation.compass, federation.gps, federation.master
    for k, sample in enumerate(feed.inertial.tolist()):
        t_ns = (k + 1) * PERIOD_NS
        for f, i in filters:
            move(f, i, t_ns, PERIOD, *sample)
        if (k + 1) % COMPASS_EVERY == 0:
            place = (k + 1) // COMPASS_EVERY - 1
            if feed.compass_told[place]:
                heading, pitch, roll = feed.compass[place].tolist()
                take_compass(g, n, *federation.compass, heading, pitch, roll, t_ns)
        if (k + 1) % GPS_EVERY == 0:
            place = (k + 1) // GPS_EVERY - 1
            if feed.epochs_told[place]:
                take_gps(g, n, *federation.gps, feed.epochs[place])
            fuse(g, n, *arrays)
            course.note(place, *federation.master)
            isolated[place] = n[gl.STATUS : gl.STATUS + 2]
            cause[place] = n[gl.ISOLATED_BY : gl.ISOLATED_BY + 2]
    recoveries = int(n[gl.RECOVERIES]), int(n[gl.RECOVERIES + 1])
    return FederatedErrors(course.errors(), isolated, cause, recoveries)


class _Course:
    """States noted once a second, compared with the truth at the end."""

    def __init__(self, feed: Feed) -> None:
        self._truth = feed.truth
        count = len(feed.truth)
        self._whole = np.empty((count, 2), np.int64)
        self._part = np.empty((count, 9))

    def note(self, place: int, f: NDArray[Any], i: NDArray[np.int64]) -> None:
        self._whole[place] = i[at.LATITUDE], i[at.LONGITUDE]
        row = self._part[place]
        row[0] = float(f[at.HEIGHT]) + float(f[at.HEIGHT_REST])
        row[1:4] = f[at.VELOCITY : at.VELOCITY + 3]
        row[4:8] = f[at.QUATERNION : at.QUATERNION + 4]
        row[8] = _variance(f, at.X_ATTITUDE + 2)

    def errors(self) -> Errors:
        latitude, longitude = (self._whole * UNIT).T
        radii = [radii_and_gravity(math.sin(place[0]), place[2]) for place in self._truth]
        meridian, normal = np.array([(one[0], one[1]) for one in radii]).T
        north = (latitude - self._truth[:, 0]) * meridian
        east = (longitude - self._truth[:, 1]) * normal * np.cos(self._truth[:, 0])
        down = self._truth[:, 2] - self._part[:, 0]
        w, x, y, z = self._part[:, 4:8].T
        roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        pitch = np.arcsin(np.clip(2 * (w * y - x * z), -1.0, 1.0))
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) - HEADING
        yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
        velocity = self._part[:, 1:4] - VELOCITY
        attitude = np.column_stack((roll, pitch, yaw))
        return Errors(np.column_stack((north, east, down)), velocity, attitude, np.sqrt(self._part[:, 8]))


def _variance(f: NDArray[Any], state: int) -> float:
    """P of one state, from its factors."""
    columns = np.arange(state + 1, at.STATES)
    above = f[at.U + columns * at.STATES + state].astype(np.float64)
    d = f[at.D : at.D + at.STATES].astype(np.float64)
    return float(d[state] + np.sum(above * above * d[state + 1 :]))
