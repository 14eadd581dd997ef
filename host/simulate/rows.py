"""Samples, truth and receiver epochs as rows of printable numbers, and the names of their columns."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch
from host.record.tables import Table
from host.sim.earth import one_turn
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE, VELOCITY
from host.sim.truth import euler_angles
from host.simulate.stream import NS, Block, Convention

Floats = NDArray[np.float64]
DEGREES = 180.0 / math.pi

RATES = tuple(
    f"{name}_{axis}_{unit}" for name, unit in (("force", "mps2"), ("rate", "radps")) for axis in "xyz"
)
INCREMENTS = tuple(
    f"{name}_{axis}_{unit}" for name, unit in (("dv", "mps"), ("dtheta", "rad")) for axis in "xyz"
)
_SIGNAL_DECIMALS = (*(12,) * 3, *(15,) * 3)

TRUTH = Table(
    (
        *("latitude_deg", "longitude_deg", "height_m", "v_north_mps", "v_east_mps", "v_down_mps"),
        *("yaw_deg", "pitch_deg", "roll_deg"),
    ),
    (12, 12, 7, 9, 9, 9, 10, 10, 10),
)
GNSS = Table(
    (
        *("t_s", "fix", "latitude_deg", "longitude_deg", "height_m"),
        *("v_north_mps", "v_east_mps", "v_down_mps", "h_acc_m", "v_acc_m", "s_acc_mps"),
        *("satellites_used", "hdop", "vdop", "latency_s"),
    ),
    (9, 0, 10, 10, 4, 4, 4, 4, 3, 3, 3, 0, 2, 2, 6),
)


def imu_table(convention: Convention) -> Table:
    """Columns of the inertial samples."""
    signals = INCREMENTS if convention is Convention.INCREMENT else RATES
    return Table(("t_s", *signals, "temperature_c"), (9, *_SIGNAL_DECIMALS, 4))


def imu_rows(block: Block) -> Floats:
    """Rows of `imu_table`."""
    return np.column_stack((block.times_ns / NS, block.felt))


def truth_rows(block: Block) -> Floats:
    """Rows of TRUTH: degrees, longitude within ±180, yaw 0 … 360."""
    rows = block.truth
    out = np.empty((len(rows), len(TRUTH.columns)))
    out[:, 0] = rows[:, LATITUDE] * DEGREES
    out[:, 1] = one_turn(rows[:, LONGITUDE]) * DEGREES
    out[:, 2] = rows[:, HEIGHT]
    out[:, 3:6] = rows[:, VELOCITY : VELOCITY + 3]
    yaw, pitch, roll = euler_angles(rows[:, C_NB : C_NB + 9])
    out[:, 6], out[:, 7], out[:, 8] = yaw * DEGREES, pitch * DEGREES, roll * DEGREES
    return out


def gnss_rows(epochs: Iterable[tuple[int, GnssEpoch]]) -> Floats:
    """Rows of GNSS; without a fix only time, counts and dilutions mean anything, the rest is NaN."""
    rows = [_gnss_row(time_ns, epoch) for time_ns, epoch in epochs]
    return np.array(rows, dtype=np.float64).reshape(-1, len(GNSS.columns))


def _gnss_row(time_ns: int, epoch: GnssEpoch) -> tuple[float, ...]:
    used = sum(satellite.used for satellite in epoch.satellites)
    end = (used, epoch.hdop, epoch.vdop, epoch.latency_ns / NS)
    if not epoch.fix:
        return (time_ns / NS, 0.0, *(math.nan,) * 9, *end)
    return (
        *(time_ns / NS, 1.0, epoch.latitude * DEGREES, epoch.longitude * DEGREES, epoch.height),
        *(*epoch.velocity_ned, epoch.h_acc, epoch.v_acc, epoch.s_acc),
        *end,
    )
