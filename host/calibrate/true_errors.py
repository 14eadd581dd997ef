"""What calibration should find: the errors that the simulated sensors really have."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.description import Board
from host.calibrate.table_world import TableWorld, level
from host.sim.errors.sensor_kernel import BIAS_A, SCALE_A
from host.sim.magnetic_field import MagneticField
from host.sim.trajectory.kinematics import HEIGHT, LATITUDE, LONGITUDE
from host.sim.vehicle_field import VehicleField

Array = NDArray[np.float64]
AXES = 9
HEADINGS = 360
ARMS = ((0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 0, -1), (-1, 0, 0), (0, -1, 0))
"""Where A1 … A6 sit, in lengths of an arm."""
INCREASE = (
    ((8, 1.0), (7, 1.0), (1, -1.0), (5, -1.0)),
    ((6, 1.0), (8, 1.0), (2, -1.0), (3, -1.0)),
    ((6, 1.0), (7, 1.0), (0, -1.0), (4, -1.0)),
)
"""Which of A1 … A9 make 2 l ω̇ about x, y, z."""


@dataclass(frozen=True)
class NineAxes:
    """Reading = rows · f + offsets, m/s²."""

    rows: Array
    """(9, 3)."""
    offsets: Array
    """(9,)."""

    def reads(self, forces: Array) -> Array:
        """(n, 9) of forces (n, 3) that all feel."""
        return forces @ self.rows.T + self.offsets

    @property
    def scales(self) -> Array:
        """Along their own axes (9,)."""
        return self.rows[np.arange(AXES), np.arange(AXES) % 3]

    def rate_response(self, scales: Array) -> Array:
        """(3, 3): what of a rate the differences show, readings divided by `scales`."""
        found = np.zeros((3, 3))
        for about in range(3):
            turning = np.eye(3)[about]
            felt = np.zeros((AXES, 3))
            felt[: len(ARMS)] = [np.cross(turning, arm) for arm in ARMS]
            read = np.einsum("kj,kj->k", self.rows, felt) / scales
            for axis, terms in enumerate(INCREASE):
                found[axis, about] = sum(sign * read[k] for k, sign in terms) / 2.0
        return found


def nine_axes(world: TableWorld, board: Board, time_ns: int) -> NineAxes:
    """Of the board's accelerometers at an instant."""
    rows, offsets = np.zeros((AXES, 3)), np.zeros(AXES)
    by_name = {chip.name: refdes for refdes, chip in board.chips.items()}
    for k in range(AXES):
        sensor = world.board.sensors[by_name[f"accelerometer{min(k, 6) + 1}"]]
        slow = sensor.slow_errors(np.array([time_ns], np.int64))[0]
        axis = k % 3
        rows[k] = sensor.specimen.accelerometer.cross[axis]
        rows[k, axis] += 1.0 + slow[SCALE_A + axis]
        offsets[k] = slow[BIAS_A + axis]
    return NineAxes(rows, offsets)


def directions(count: int) -> Array:
    """(n, 3) unit vectors, evenly spread over the sphere (a Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    around = math.pi * (1.0 + math.sqrt(5.0)) * k
    return np.column_stack((np.cos(around) * np.sqrt(1.0 - z * z), np.sin(around) * np.sqrt(1.0 - z * z), z))


def shown_headings(world: TableWorld) -> tuple[Array, Array]:
    """Magnetic headings (rad) of the level board, and what a compass without noise shows there."""
    true = np.arange(HEADINGS) * 2.0 * math.pi / HEADINGS
    here = world.table.looked_at(np.zeros(1, np.int64))
    place = tuple(np.full(HEADINGS, here[0, column]) for column in (LATITUDE, LONGITUDE, HEIGHT))
    attitudes = np.array([level(angle + world.declination) for angle in true])
    field = MagneticField(world.scenario.start.utc)
    errors = world.scenario.magnetometer.model_copy(update={"noise_ut": 0.0})
    vehicle = VehicleField(field, errors, world.seed, "truth")
    felt = vehicle.felt(vehicle.true((place[0], place[1], place[2]), attitudes))
    return true, np.arctan2(-felt[:, 1], felt[:, 0]) % (2.0 * math.pi)
