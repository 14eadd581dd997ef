"""Navigate a drive offline and compare with its truth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from nav_drive import NS, Array, Drive, within_pi
from numpy.typing import NDArray

from firmware.nav import gnss, imu, solution, temperature
from firmware.nav.config import NavConfig, new_state
from firmware.nav.flags import FLAG_NAMES

A, E2 = 6378137.0, 0.00669437999014


@dataclass
class Result:
    """Errors (solution − truth) at the times of truth."""

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
    """(m, 2) time, normalised squared error of nine."""
    biases: Array
    """(n, 18) of `solution.biases`."""
    floats: Array
    integers: NDArray[np.int64]
    f: NDArray[Any]
    i: NDArray[np.int64]

    @property
    def horizontal(self) -> Array:
        """Horizontal error in m."""
        return np.hypot(self.position[:, 0], self.position[:, 1])

    def at(self, t: float) -> int:
        """Row of a time in s."""
        return int(np.argmin(np.abs(self.t - t)))

    def seen(self, name: str) -> NDArray[np.bool_]:
        """When a flag was up."""
        return (self.flags >> FLAG_NAMES.index(name)) & 1 == 1


def run(
    drive: Drive,
    config: NavConfig,
    doors: tuple[ModuleType, ModuleType, ModuleType, ModuleType] = (imu, gnss, solution, temperature),
) -> Result:
    """Feed samples and epochs in the order of their arrival; `doors` of another precision if given."""
    step, fix, out, warm = doors[0].imu_step, doors[1].gnss_step, doors[2], doors[3].temperature_step
    wide = np.float32 if doors[0] is imu else np.float64
    f, i = new_state(config, wide)
    floats, integers = np.zeros(out.SOLUTION_FLOATS, wide), np.zeros(out.SOLUTION_INTEGERS, np.int64)
    triangle, bias = np.zeros(out.COVARIANCE_FLOATS, wide), np.zeros(out.BIAS_FLOATS, wide)
    due_ns = drive.truth.times_ns.tolist()
    found: list[tuple[Array, NDArray[np.int64], Array, float]] = []
    triangles: list[tuple[int, Array]] = []
    pending = iter([*drive.epochs, (1 << 62, None)])
    arrival, record = next(pending)
    previous = int(drive.times_ns[0]) - 10_000_000
    read_at = previous
    samples = zip(drive.times_ns.tolist(), drive.samples.tolist(), drive.temperature.tolist(), strict=True)
    for time, sample, celsius in samples:
        while arrival <= time:
            fix(f, i, record)
            arrival, record = next(pending)
        if time >= read_at:
            warm(f, i, celsius)
            read_at = time + NS
        step(f, i, time, (time - previous) * 1e-9, *sample)
        previous = time
        while len(found) < len(due_ns) and time >= due_ns[len(found)]:
            out.solution(f, i, floats, integers)
            out.biases(f, bias)
            if len(found) % 10 == 0 and integers[out.MODE] >= 3:
                out.covariance(f, triangle)
                triangles.append((len(found), triangle.astype(float)))
            lag = (time - due_ns[len(found)]) * 1e-9
            found.append((floats.astype(float), integers.copy(), bias.astype(float), lag))
    return _compare(drive, found, triangles, f, i)


def _compare(
    drive: Drive, found: list[Any], triangles: list[Any], f: NDArray[Any], i: NDArray[np.int64]
) -> Result:
    floats, integers, biases = (np.array([row[k] for row in found]) for k in range(3))
    lag = np.array([row[3] for row in found])
    n, true = len(found), drive.truth
    lat, lon = np.radians(integers[:, 1] * 1e-9), np.radians(integers[:, 2] * 1e-9)
    w2 = 1.0 - E2 * np.sin(true.latitude[:n]) ** 2
    north = (lat - true.latitude[:n]) * (A * (1 - E2) / w2**1.5 + true.height[:n])
    east = within_pi(lon - true.longitude[:n]) * (A / np.sqrt(w2) + true.height[:n]) * np.cos(lat)
    position = np.column_stack((north, east, true.height[:n] - floats[:, 0])) - floats[:, 1:4] * lag[:, None]
    velocity = floats[:, 1:4] - true.v_ned[:n]
    angles = zip((true.roll, true.pitch, true.yaw), (6, 5, 4), strict=True)
    attitude = np.column_stack([within_pi(floats[:, k] - angle[:n]) for angle, k in angles])
    t = true.times_ns[:n] / NS
    nees = []
    for k, triangle in triangles:
        phi = rotation_error(floats[k, 4:7], np.array((true.yaw[k], true.pitch[k], true.roll[k])))
        x = np.concatenate((-position[k], -velocity[k], phi))
        nees.append((t[k], x @ np.linalg.solve(full_matrix(triangle), x)))
    return Result(
        t, position, velocity, attitude, integers[:, 3], integers[:, 4], floats[:, 10:19],
        np.array(nees).reshape(-1, 2), biases, floats, integers, f, i,
    )  # fmt: skip


def full_matrix(triangle: Array) -> Array:
    """Symmetric 9 x 9 from its upper triangle, row by row."""
    upper = np.zeros((9, 9))
    upper[np.triu_indices(9)] = triangle
    return upper + np.triu(upper, 1).T


def dcm(yaw: float, pitch: float, roll: float) -> Array:
    """C_n_b of Z-Y-X Euler angles."""
    sy, cy, sp, cp, sr, cr = (g(a) for a in (yaw, pitch, roll) for g in (math.sin, math.cos))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation_error(told: Array, true: Array) -> Array:
    """φ with C_true = (I + [φ×]) C_told, rad NED, from (yaw, pitch, roll)."""
    d = dcm(*true) @ dcm(*told).T
    return 0.5 * np.array([d[2, 1] - d[1, 2], d[0, 2] - d[2, 0], d[1, 0] - d[0, 1]])


def scored(result: Result, drive: Drive) -> NDArray[np.bool_]:
    """Times that count: 60 s after alignment, with GNSS since 10 s (2 s of which it takes to come back)."""
    aligned = np.flatnonzero(result.mode >= 3)
    if len(aligned) == 0:
        return np.zeros(len(result.t), bool)
    ok = (result.t > result.t[aligned[0]] + 60.0) & (result.mode >= 3)
    for start, end in drive.outages:
        ok &= ~((result.t > start) & (result.t < end + 12.0))
    return ok


def rms(values: Array) -> float:
    """Root mean square; of vectors, of their lengths."""
    return float(np.sqrt(np.mean(np.sum(values**2, axis=1) if values.ndim == 2 else values**2)))


@dataclass(frozen=True)
class Figures:
    """RMS over the scored times."""

    horizontal_m: float
    gnss_horizontal_m: float
    velocity_mps: float
    roll_deg: float
    pitch_deg: float
    yaw_deg: float
    nees: float
    drifts_m: tuple[float, ...]


def figures(result: Result, drive: Drive) -> Figures:
    """The figures that are asked for."""
    ok = scored(result, drive)
    fix_ok = np.interp(drive.fixes[:, 0], result.t, ok.astype(float)) > 0.99
    nees_ok = np.interp(result.nees[:, 0], result.t, ok.astype(float)) > 0.99
    roll, pitch, yaw = (math.degrees(rms(result.attitude[ok, k])) for k in range(3))
    return Figures(
        rms(result.position[ok, :2]),
        rms(drive.fixes[fix_ok, 1:3]),
        rms(result.velocity[ok]),
        roll,
        pitch,
        yaw,
        float(np.mean(result.nees[nees_ok, 1])),
        tuple(float(result.horizontal[result.at(end)]) for _, end in drive.outages),
    )
