"""A drive with known truth and errors of a known kind, for tests of scoring, capture and report."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from host.record.run_data import GnssBatch, MotionBatch, SolutionBatch

LATITUDE, LONGITUDE, HEIGHT = np.radians(47.3), np.radians(8.5), 450.0
# Radii of WGS-84 at 47.3° from the closed forms, with e² = 0.00669437999014.
_W = np.sqrt(1 - 0.00669437999014 * np.sin(LATITUDE) ** 2)
NORTH_RADIUS = 6378137.0 * (1 - 0.00669437999014) / _W**3 + HEIGHT
EAST_RADIUS = (6378137.0 / _W + HEIGHT) * np.cos(LATITUDE)


def times(start: float, end: float, rate: float) -> np.ndarray:
    """Instants start, start + 1/rate … below end."""
    return start + np.arange(round((end - start) * rate)) / rate


def motion(t: np.ndarray) -> MotionBatch:
    """A car on a circle of 200 m radius at 10 m/s, heading along the circle, a little roll and pitch."""
    angle = t * 10 / 200
    north, east = 200 * np.sin(angle), 200 * (1 - np.cos(angle))
    velocity = np.stack((10 * np.cos(angle), 10 * np.sin(angle), np.zeros_like(t)), axis=1)
    return MotionBatch(
        t=t,
        latitude=LATITUDE + north / NORTH_RADIUS,
        longitude=LONGITUDE + east / EAST_RADIUS,
        height=np.full_like(t, HEIGHT),
        velocity_ned=velocity,
        yaw=np.mod(angle, 2 * np.pi),
        pitch=0.01 * np.sin(t / 7),
        roll=0.02 * np.sin(t / 5),
    )


@dataclass
class Errors:
    """Errors to be put on a solution: arrays (n, 3), or 3 numbers for constant ones."""

    position: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw_pitch_roll: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0)


def _columns(values: np.ndarray | tuple[float, float, float], count: int) -> np.ndarray:
    return np.broadcast_to(np.asarray(values, dtype=float), (count, 3))


def solution(t: np.ndarray, errors: Errors | None = None, mode: int = 3) -> SolutionBatch:
    """The drive as a board with the given errors would report it."""
    errors = errors or Errors()
    truth = motion(t)
    position = _columns(errors.position, len(t))
    angles = _columns(errors.yaw_pitch_roll, len(t))
    return SolutionBatch(
        t=t,
        latitude=truth.latitude + position[:, 0] / NORTH_RADIUS,
        longitude=truth.longitude + position[:, 1] / EAST_RADIUS,
        height=truth.height - position[:, 2],
        velocity_ned=truth.velocity_ned + _columns(errors.velocity, len(t)),
        yaw=np.mod(truth.yaw + angles[:, 0], 2 * np.pi),
        pitch=truth.pitch + angles[:, 1],
        roll=truth.roll + angles[:, 2],
        sigma_position=np.full((len(t), 3), 0.8),
        sigma_velocity=np.full((len(t), 3), 0.05),
        sigma_attitude=np.full((len(t), 3), 0.005),
        mode=np.full(len(t), mode),
        flags=np.zeros(len(t), dtype=np.int64),
    )


def gnss(t: np.ndarray, errors: Errors | None = None, fix: np.ndarray | bool = True) -> GnssBatch:
    """The receiver's epochs with the given errors."""
    report = solution(t, errors)
    return GnssBatch(
        t=t,
        fix=np.broadcast_to(np.asarray(fix), t.shape),
        latitude=report.latitude,
        longitude=report.longitude,
        height=report.height,
        velocity_ned=report.velocity_ned,
    )
