"""The world of one run: what the chips feel and what was true, simulated or from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import CompassWorld, GnssWorld, ImuWorld, TenDofWorld
from host.sim.compass import FeltCompass
from host.sim.compass_ahead import CompassAhead
from host.sim.gnss.faults import glitches_of, refuse_baseline_faults
from host.sim.gnss.glitched import GlitchedReceiver
from host.sim.gnss.schedule import Window
from host.sim.magnetic_field import MagneticField
from host.sim.scenario.errors import ScenarioError, named
from host.sim.scenario.schema import Scenario
from host.sim.simulated import SimulatedVehicle
from host.sim.ten_dof import FeltTenDof
from host.sim.truth import TruthBatch
from host.sim.vehicle_field import StaticPressure, VehicleField

Array = NDArray[np.float64]


class Vehicle(Protocol):
    """What a simulated and a recorded drive have in common."""

    duration_ns: int
    looks_ahead: bool
    """Whether its truth may be asked for seconds ahead of the present."""
    outages: tuple[Window, ...]

    def imu(self, name: str, mounting: Array, lever_arm: Array, preset: str | None = None) -> ImuWorld:
        """The world of an inertial sensor."""
        ...

    def gnss(self, name: str, lever_arm: Array, second_lever_arm: Array | None = None) -> GnssWorld:
        """The world of a receiver; ScenarioError when it cannot have two antennas."""
        ...

    def truth(self, times_ns: NDArray[np.int64], imu: str | None = None) -> TruthBatch:
        """Truth at the origin."""
        ...

    def antenna_truth(self, times_ns: NDArray[np.int64], lever_arm: Array) -> TruthBatch:
        """Truth at a point of the body."""
        ...


class World:
    """Made once a run from (scenario, seed, folder of recordings); the same three give the same world."""

    def __init__(self, scenario: Scenario, seed: int = 1, data_dir: Path | None = None) -> None:
        """`data_dir` None: the environment variable NAVTWIN_DATA. Raises ScenarioError."""
        self.scenario = scenario
        self.seed = seed
        self._data_dir = data_dir
        self._vehicle: Vehicle = _vehicle(scenario, seed, data_dir)
        self._ahead: list[CompassAhead] = []

    def another(self) -> World:
        """A world like this one, at its beginning."""
        return World(self.scenario, self.seed, self._data_dir)

    @property
    def duration_ns(self) -> int:
        """Length of the run."""
        return self._vehicle.duration_ns

    @property
    def outages(self) -> tuple[Window, ...]:
        """Windows without satellite signals."""
        return self._vehicle.outages

    def imu(
        self,
        name: str,
        mounting: Array | None = None,
        lever_arm: Array | None = None,
        preset: str | None = None,
    ) -> ImuWorld:
        """The world of the inertial sensor `name`.

        `mounting` = C_b_s (3, 3), body = C_b_s sensor (default: aligned); `lever_arm` (3,) from the vehicle's
        origin in body axes, m; `preset`: the board's error preset, which the scenario may replace.
        """
        rotation = np.eye(3) if mounting is None else np.asarray(mounting, dtype=np.float64)
        lever = np.zeros(3) if lever_arm is None else np.asarray(lever_arm, dtype=np.float64)
        return self._vehicle.imu(name, rotation, lever, preset)

    def gnss(
        self, name: str, lever_arm: Array | None = None, second_lever_arm: Array | None = None
    ) -> GnssWorld:
        """The world of the receiver `name` with its antenna at `lever_arm` (body axes, m).

        With `second_lever_arm` its epochs have a `baseline`, from the one antenna to the other (a recorded
        drive knows none).
        With faults of its own it has `glitches`, which count how often they struck.
        """
        lever = np.zeros(3) if lever_arm is None else np.asarray(lever_arm, dtype=np.float64)
        receiver = self._vehicle.gnss(name, lever, second_lever_arm)
        with named(self.scenario.path, self.scenario.name):
            if second_lever_arm is None:
                refuse_baseline_faults(self.scenario.fault, name)
            glitches = glitches_of(self.scenario.fault, name, self.duration_ns, self.seed)
        return GlitchedReceiver(receiver, glitches) if glitches else receiver

    def compass(self, name: str, mounting: Array | None = None) -> CompassWorld:
        """The world of the compass `name` at the vehicle's origin; `mounting` as for `imu`."""
        rotation = np.eye(3) if mounting is None else np.asarray(mounting, dtype=np.float64)
        errors = self.scenario.compass
        felt = FeltCompass(self.truth, self._field(name), rotation, self.seed, name, errors)
        if not self._vehicle.looks_ahead:
            return felt
        compass = CompassAhead(felt)
        self._ahead.append(compass)
        return compass

    def ten_dof(
        self,
        name: str,
        mounting: Array | None = None,
        lever_arm: Array | None = None,
        preset: str | None = None,
    ) -> TenDofWorld:
        """The world of a sensor of rate, force, magnetic field and pressure; arguments as for `imu`."""
        rotation = np.eye(3) if mounting is None else np.asarray(mounting, dtype=np.float64)
        imu = self.imu(name, rotation, lever_arm, preset)
        pressure = StaticPressure(
            self.scenario.barometer, self._geoid_separation_m, self.seed, f"{name}.baro"
        )
        around = self._field(name), pressure
        return FeltTenDof(imu, self.truth, around, rotation, self.seed, name, perfect=preset == "perfect")

    def _field(self, name: str) -> VehicleField:
        scenario = self.scenario
        field = MagneticField(scenario.start.utc)
        return VehicleField(field, scenario.magnetometer, self.seed, f"{name}.magnetometer")

    @property
    def _geoid_separation_m(self) -> float:
        scenario = self.scenario
        if scenario.recording is not None:
            return scenario.recording.geoid_separation_m
        return 0.0 if scenario.place is None else scenario.place.geoid_separation_m

    def put_down(self, time_ns: int, latitude: float, longitude: float, height: float) -> None:
        """From `time_ns` on the standing vehicle stands there (rad, m). Raises ScenarioError if it moves."""
        if not isinstance(self._vehicle, SimulatedVehicle):
            raise ScenarioError(
                f"scenario {self.scenario.name}: its drive is recorded; only a simulated vehicle that stands"
                " can be put elsewhere, for example in the scenario static"
            )
        self._vehicle.put_down(time_ns, (latitude, longitude, height))
        for compass in self._ahead:
            compass.forget()

    def truth(self, times_ns: NDArray[np.int64], imu: str | None = None) -> TruthBatch:
        """Truth at the vehicle's origin at rising times; biases of the sensor `imu` (else the first made)."""
        return self._vehicle.truth(np.asarray(times_ns, dtype=np.int64), imu)

    def antenna_truth(self, times_ns: NDArray[np.int64], lever_arm: Array) -> TruthBatch:
        """Truth at the antenna at rising times; the attitude is the body's."""
        return self._vehicle.antenna_truth(np.asarray(times_ns, dtype=np.int64), np.asarray(lever_arm))


def _vehicle(scenario: Scenario, seed: int, data_dir: Path | None) -> Vehicle:
    if scenario.kind == "recording":
        from host.sim.recording.drive import RecordedDrive

        return RecordedDrive(scenario, data_dir)
    return SimulatedVehicle(scenario, seed)
