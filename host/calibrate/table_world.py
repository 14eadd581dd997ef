"""The world of a board on a turning table: the scenario's place, field and sensors, the table's motion."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import ImuWorld
from host.record.errors import UserError
from host.sim.errors.inertial_sensor import InertialSensor
from host.sim.magnetic_field import MagneticField
from host.sim.scenario.schema import Scenario
from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE, VELOCITY
from host.sim.truth import TruthBatch, euler_angles, unknown_bias
from host.sim.turning_table import TurningTable
from host.sim.world import World

Array = NDArray[np.float64]
MOST_AHEAD_S = 0.25
"""The table is told what to do while sensors are being read."""


def level(heading: float) -> Array:
    """C_n_b of the level body at a heading (rad, true)."""
    s, c = math.sin(heading), math.cos(heading)
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))


class SensorOnTable:
    """Implements `boards.chips.world.ImuWorld`."""

    most_ahead_s = MOST_AHEAD_S

    def __init__(self, sensor: InertialSensor) -> None:
        self.sample = sensor.sample


class MountedBoard(SimulatedVehicle):
    """A vehicle that stands, inertial sensors and compass on the table, the antenna outside."""

    looks_ahead = False

    def __init__(self, scenario: Scenario, seed: int) -> None:
        super().__init__(scenario, seed)
        rows = self.motion.rows(np.zeros(1, np.int64))
        latitude, longitude, height = rows[0, [LATITUDE, LONGITUDE, HEIGHT]].tolist()
        self.table = TurningTable(latitude, longitude, height, np.eye(3))

    def imu(self, name: str, mounting: Array, lever_arm: Array, preset: str | None = None) -> ImuWorld:  # type: ignore[override]
        """A sensor on the table."""
        sensor = super().imu(name, mounting, lever_arm, preset)
        sensor.put_on(self.table)
        return SensorOnTable(sensor)

    def truth(self, times_ns: NDArray[np.int64], imu: str | None = None) -> TruthBatch:
        """Truth of the table."""
        rows = self.table.looked_at(times_ns)
        yaw, pitch, roll = euler_angles(rows[:, C_NB : C_NB + 9])
        unknown = unknown_bias(len(times_ns))
        return TruthBatch(
            times_ns,
            rows[:, LATITUDE].copy(),
            rows[:, LONGITUDE].copy(),
            rows[:, HEIGHT].copy(),
            rows[:, VELOCITY : VELOCITY + 3].copy(),
            yaw,
            pitch,
            roll,
            unknown,
            unknown,
        )


class TableWorld(World):
    """Its scenario must be one of rest."""

    def __init__(self, scenario: Scenario, seed: int) -> None:
        super().__init__(scenario, seed)
        if any(segment.kind != "rest" for segment in scenario.segment) or scenario.kind == "recording":
            raise UserError(
                f"scenario {scenario.name}: its vehicle moves; a board is calibrated at rest on a table, for"
                " example in the scenario turntable"
            )
        self.board = MountedBoard(scenario, seed)
        self._vehicle = self.board

    @property
    def table(self) -> TurningTable:
        """What turns the board."""
        return self.board.table

    @property
    def declination(self) -> float:
        """From true to magnetic north at the place, east positive, rad."""
        here = self.table.looked_at(np.zeros(1, np.int64))
        place = here[:, LATITUDE], here[:, LONGITUDE], here[:, HEIGHT]
        north, east, _ = MagneticField(self.scenario.start.utc).turned(place, np.eye(3)[None])[0]
        return math.atan2(east, north)
