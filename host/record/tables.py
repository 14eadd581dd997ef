"""The columns of everything decoded that leaves a run: solution.csv, the capture's topics, the report.

A name ends in its unit. `decimals` is what is printed; the last digit lies well below what a receiver or a
float32 solution can resolve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.link.messages import Sensor
from host.record.run_data import BiasEstimate, GnssBatch, Innovation, SolutionBatch

Floats = NDArray[np.float64]

DEGREES = 180 / np.pi


@dataclass(frozen=True, slots=True)
class Table:
    """A kind of row: column names, and decimals for print."""

    columns: tuple[str, ...]
    decimals: tuple[int, ...]


def _table(*groups: tuple[int, str]) -> Table:
    columns: list[str] = []
    decimals: list[int] = []
    for places, names in groups:
        columns += names.split()
        decimals += [places] * len(names.split())
    return Table(tuple(columns), tuple(decimals))


SOLUTION = _table(
    (6, "t_s"),
    (9, "latitude_deg longitude_deg"),
    (3, "height_m"),
    (4, "v_north_mps v_east_mps v_down_mps yaw_deg pitch_deg roll_deg"),
    (3, "sigma_north_m sigma_east_m sigma_down_m"),
    (
        4,
        "sigma_v_north_mps sigma_v_east_mps sigma_v_down_mps sigma_psi_n_deg sigma_psi_e_deg sigma_psi_d_deg",
    ),
    (0, "mode flags"),
    (3, "error_north_m error_east_m error_down_m"),
    (4, "error_v_north_mps error_v_east_mps error_v_down_mps error_yaw_deg error_pitch_deg error_roll_deg"),
)

GNSS = _table(
    (6, "t_s"),
    (0, "fix"),
    (9, "latitude_deg longitude_deg"),
    (3, "height_m"),
    (4, "v_north_mps v_east_mps v_down_mps"),
    (3, "error_north_m error_east_m error_down_m"),
    (4, "error_v_north_mps error_v_east_mps error_v_down_mps"),
)

INNOVATION = _table(
    (6, "t_s"),
    (4, "north_m east_m down_m v_north_mps v_east_mps v_down_mps"),
    (4, "sigma_north_m sigma_east_m sigma_down_m sigma_v_north_mps sigma_v_east_mps sigma_v_down_mps"),
    (0, "used"),
)

SLOW_STATES = (
    *("gyro_x_dps", "gyro_y_dps", "gyro_z_dps", "accel_x_mps2", "accel_y_mps2", "accel_z_mps2"),
    *("mounting_yaw_deg", "mounting_pitch_deg", "latency_s"),
)
_TO_PRINT = np.array([DEGREES] * 3 + [1.0] * 3 + [DEGREES] * 2 + [1.0])

BIAS = _table(
    (6, "t_s"),
    (6, " ".join(SLOW_STATES)),
    (6, " ".join(f"sigma_{name}" for name in SLOW_STATES)),
    (6, " ".join(f"true_{name}" for name in SLOW_STATES)),
)

SENSOR = _table((6, "t_s"), (0, " ".join(Sensor._fields[1:])))
"""How the inertial sensor is, as a board's SENSOR frames tell it."""


FILTER = _table(
    (6, "t_s"),
    (0, "filter status"),
    (3, "error_north_m error_east_m error_down_m"),
    (4, "error_v_north_mps error_v_east_mps error_v_down_mps error_yaw_deg error_pitch_deg error_roll_deg"),
    (3, "sigma_north_m sigma_east_m sigma_down_m"),
    (
        4,
        "sigma_v_north_mps sigma_v_east_mps sigma_v_down_mps sigma_psi_n_deg sigma_psi_e_deg sigma_psi_d_deg",
    ),
)
"""What filters side by side take for the state, less the truth; `filter`: 0, 1, … in the board's order."""


def filter_rows(which: Floats, status: Floats, solution: SolutionBatch, errors: Floats) -> Floats:
    """Rows of FILTER. `errors`: (n, 12) of `host.score.errors`."""
    rows: Floats = np.column_stack(
        (
            solution.t,
            which,
            status,
            errors[:, 0:6],
            errors[:, 11:8:-1] * DEGREES,
            solution.sigma_position,
            solution.sigma_velocity,
            solution.sigma_attitude * DEGREES,
        )
    )
    return rows


def solution_rows(solution: SolutionBatch, errors: Floats) -> Floats:
    """Rows of SOLUTION. `errors`: (n, 12) of `host.score.errors`; NaN where there is no truth."""
    rows: Floats = np.column_stack(
        (
            solution.t,
            solution.latitude * DEGREES,
            solution.longitude * DEGREES,
            solution.height,
            solution.velocity_ned,
            np.column_stack((solution.yaw, solution.pitch, solution.roll)) * DEGREES,
            solution.sigma_position,
            solution.sigma_velocity,
            solution.sigma_attitude * DEGREES,
            solution.mode,
            solution.flags,
            errors[:, 0:6],
            errors[:, 11:8:-1] * DEGREES,
        )
    )
    return rows


def gnss_rows(epochs: GnssBatch, errors: Floats) -> Floats:
    """Rows of GNSS. `errors`: (n, 6), NaN without a fix."""
    rows: Floats = np.column_stack(
        (
            epochs.t,
            epochs.fix,
            epochs.latitude * DEGREES,
            epochs.longitude * DEGREES,
            epochs.height,
            epochs.velocity_ned,
            errors,
        )
    )
    rows[~epochs.fix, 2:] = np.nan
    return rows


def innovation_rows(innovations: Sequence[Innovation]) -> Floats:
    """Rows of INNOVATION."""
    return np.array([(one.t, *one.values, *one.sigmas, one.used) for one in innovations], dtype=np.float64)


def bias_rows(biases: Sequence[BiasEstimate]) -> Floats:
    """Rows of BIAS; NaN where no truth is known."""
    unknown = (np.nan,) * len(SLOW_STATES)
    padded = [((one.truth or ()) + unknown)[: len(SLOW_STATES)] for one in biases]
    rows = np.array(
        [(one.t, *one.values, *one.sigmas, *truth) for one, truth in zip(biases, padded, strict=True)],
        dtype=np.float64,
    )
    rows[:, 1:] *= np.tile(_TO_PRINT, 3)
    return rows
