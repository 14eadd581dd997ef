"""Navigate a drive with an attitude reference and compare with its truth, once a second."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from nav_drive import within_pi
from nav_run import full_matrix, rotation_error
from numpy.typing import NDArray
from tactical_drive import ARRIVAL_NS, E2, NS, STEP_NS, A, Array, Drive

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.config import NavConfig, new_state
from firmware.nav.flags import FLAG_NAMES
from firmware.numerics.precision import load


@functools.cache
def doors(precision: str) -> tuple[ModuleType, ...]:
    """(imu, gnss, attitude_reference, solution, reference_report)."""
    names = ("imu", "gnss", "attitude_reference", "solution", "reference_report")
    return tuple(load(f"firmware.nav.{name}", precision) for name in names)


@dataclass
class Result:
    """Errors (solution − truth) at full seconds."""

    t: Array
    position: Array
    velocity: Array
    attitude: Array
    """Roll, pitch, yaw, rad."""
    mode: NDArray[np.int64]
    flags: NDArray[np.int64]
    sigma: Array
    """(n, 9)."""
    nees: Array
    """(n,) of nine; NaN before navigation."""
    reports: Array
    """(n, 9) floats of the attitude report, and their integers (n, 9)."""
    counts: NDArray[np.int64]
    f: NDArray[Any]
    i: NDArray[np.int64]

    def seen(self, name: str) -> NDArray[np.bool_]:
        """When a flag was up."""
        return (self.flags >> FLAG_NAMES.index(name)) & 1 == 1

    def scored(self, after_s: float = 60.0) -> NDArray[np.bool_]:
        """Seconds that count: so long after navigation began."""
        begun = np.flatnonzero(self.mode >= 3)
        return (self.mode >= 3) & (self.t > (self.t[begun[0]] + after_s if len(begun) else math.inf))


def run(drive: Drive, config: NavConfig, precision: str = "float64") -> Result:
    """Feed samples and epochs in the order of their arrival."""
    imu, fix, reference, out, report = doors(precision)
    real = np.dtype(precision)
    f, i = new_state(config, real)
    floats, integers = np.zeros(out.SOLUTION_FLOATS, real), np.zeros(out.SOLUTION_INTEGERS, np.int64)
    triangle = np.zeros(out.COVARIANCE_FLOATS, real)
    told, counts = np.zeros(report.ATTITUDE_FLOATS, real), np.zeros(report.ATTITUDE_INTEGERS, np.int64)
    step, dt = imu.imu_step, STEP_NS / NS
    pending = iter([*((int(e[gnss.VALID_NS]) + ARRIVAL_NS, e) for e in drive.epochs), (1 << 62, None)])
    arrival, record = next(pending)
    found: list[Any] = []
    for time, sample in zip(drive.times_ns.tolist(), drive.samples.tolist(), strict=True):
        while arrival <= time:
            fix.gnss_step(f, i, record)
            reference.attitude_step(f, i, record)
            arrival, record = next(pending)
        step(f, i, time, dt, *sample)
        if time % NS == 0 and len(found) < len(drive.truth.times_ns):
            out.solution(f, i, floats, integers)
            out.covariance(f, triangle)
            report.attitude_report(f, i, told, counts)
            found.append(
                [x.astype(float) for x in (floats, triangle, told)] + [integers.copy(), counts.copy()]
            )
    return _compare(drive, found, f, i)


def _compare(drive: Drive, found: list[Any], f: NDArray[Any], i: NDArray[np.int64]) -> Result:
    floats, triangles, told, integers, counts = (np.array([row[k] for row in found]) for k in range(5))
    true, n = drive.truth, len(found)
    lat, lon = np.radians(integers[:, 1] * 1e-9), np.radians(integers[:, 2] * 1e-9)
    w2 = 1.0 - E2 * np.sin(true.latitude[:n]) ** 2
    north = (lat - true.latitude[:n]) * (A * (1 - E2) / w2**1.5 + true.height[:n])
    east = within_pi(lon - true.longitude[:n]) * (A / np.sqrt(w2) + true.height[:n]) * np.cos(lat)
    position = np.column_stack((north, east, true.height[:n] - floats[:, 0]))
    velocity = floats[:, 1:4] - true.v_ned[:n]
    angles = zip((true.roll, true.pitch, true.yaw), (6, 5, 4), strict=True)
    attitude = np.column_stack([within_pi(floats[:, k] - angle[:n]) for angle, k in angles])
    nees = np.full(n, math.nan)
    for k in np.flatnonzero(integers[:, 3] >= 3):
        phi = rotation_error(floats[k, 4:7], np.array((true.yaw[k], true.pitch[k], true.roll[k])))
        x = np.concatenate((-position[k], -velocity[k], phi))
        nees[k] = x @ np.linalg.solve(full_matrix(triangles[k]), x)
    t, sigma = true.times_ns[:n] / NS, floats[:, 10:19]
    mode, flags = integers[:, 3], integers[:, 4]
    return Result(t, position, velocity, attitude, mode, flags, sigma, nees, told, counts, f, i)
