"""What came over the board's wires, decoded, in batches; and what is kept of it for the report.

Times are s of virtual time, angles rad, positions WGS-84 latitude, longitude and ellipsoidal height,
velocities north-east-down m/s; arrays are float64 with one row for each instant. `velocity_ned` and the
sigmas have shape (n, 3), everything else (n,).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from host.link.messages import Sensor
from host.record.can_course import CanCourse
from host.record.screens import Screen
from host.record.series import DecimatedSeries

Floats = NDArray[np.float64]

NAVIGATING = 3
"""From this mode on a solution is a navigation solution (0 waiting, 1 levelling, 2 waiting for heading,
3 navigating, 4 degraded)."""

STATUS_COLUMNS = (
    *("t_s", "samples_missed", "samples_repeated", "bad_checksums", "garbage_bytes"),
    *("frames_dropped", "imu_starts"),
)
"""Counters of trouble in the board's STATUS frames, since the processor's last reset."""
STATUS_LIMIT = 4096
SENSOR_COLUMNS = ("t_s", *Sensor._fields[1:])


@dataclass(frozen=True, slots=True)
class MotionBatch:
    """Where a point of the vehicle (navigation point or antenna) truly was, at the instants of a batch."""

    t: Floats
    latitude: Floats
    longitude: Floats
    height: Floats
    velocity_ned: Floats
    yaw: Floats
    pitch: Floats
    roll: Floats


@dataclass(frozen=True, slots=True)
class SolutionBatch:
    """Solutions of the board. `t` is the virtual time for which a solution holds."""

    t: Floats
    latitude: Floats
    longitude: Floats
    height: Floats
    velocity_ned: Floats
    yaw: Floats
    pitch: Floats
    roll: Floats
    sigma_position: Floats
    """1 σ north, east, down in m."""
    sigma_velocity: Floats
    sigma_attitude: Floats
    """1 σ of the rotation vector in n, rad."""
    mode: NDArray[np.int64]
    flags: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True, slots=True)
class GnssBatch:
    """Epochs of the receiver as the board understood them. `t` is the true virtual time of validity.

    Without a `fix` the other figures mean nothing. `velocity_ned` holds NaN where the receiver gave none
    (its down component with RMC or VTG alone).
    """

    t: Floats
    fix: NDArray[np.bool_]
    latitude: Floats
    longitude: Floats
    height: Floats
    velocity_ned: Floats

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True, slots=True)
class Innovation:
    """Innovations of one GNSS update: position m and velocity m/s, NED; σ from the filter's S diagonal."""

    t: float
    values: tuple[float, float, float, float, float, float]
    sigmas: tuple[float, float, float, float, float, float]
    used: int
    """Bit i is set when component i was used."""


@dataclass(frozen=True, slots=True)
class BiasEstimate:
    """Slow states: gyro bias rad/s, accelerometer bias m/s², mounting yaw and pitch rad, GNSS latency s."""

    t: float
    values: tuple[float, ...]
    """b_g x, y, z, b_a x, y, z, mounting yaw, mounting pitch, latency (9)."""
    sigmas: tuple[float, ...]
    truth: tuple[float, ...] | None = None
    """True b_g and b_a (6), or all nine; None: not known."""


@dataclass(frozen=True, slots=True)
class TaskTrace:
    """A recorded window of one processor: which task ran from when to when (s of virtual time)."""

    processor: str
    names: tuple[str, ...]
    tasks: NDArray[np.int64]
    """Of each activation, the place of its task in `names`."""
    starts: Floats
    ends: Floats


@dataclass
class RunData:
    """Bounded, decimated series of a run, for the report.

    `solution` and `gnss` have the columns of `host.record.tables` and after them places in the plane
    (`east_m`, `north_m` from the first true position; `true_east_m`, `true_north_m`, `true_height_m`).
    """

    solution: DecimatedSeries
    gnss: DecimatedSeries
    innovations: DecimatedSeries
    biases: DecimatedSeries
    nees: DecimatedSeries = field(default_factory=lambda: DecimatedSeries(("t_s", "nees"), 2))
    """NEES of the instants that count."""
    outages: tuple[tuple[float, float], ...] = ()
    """(start, duration) in s."""
    traces: list[TaskTrace] = field(default_factory=list)
    status: DecimatedSeries = field(default_factory=lambda: DecimatedSeries(STATUS_COLUMNS, STATUS_LIMIT))
    sensor: DecimatedSeries = field(default_factory=lambda: DecimatedSeries(SENSOR_COLUMNS, STATUS_LIMIT))
    """Rows of `host.record.tables.SENSOR`, ages that are not known NaN."""
    filters: list[DecimatedSeries] = field(default_factory=list)
    """Of filters side by side, in the board's order: rows of `host.record.tables.FILTER`."""
    can: list[CanCourse] = field(default_factory=list)
    screens: list[Screen] = field(default_factory=list)
    """What an operator saw on the board's display."""
