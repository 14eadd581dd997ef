"""What a sensor of rate, force, magnetic field and pressure feels: an inertial sensor and more columns.

Field and pressure are those on board (`host.sim.vehicle_field`): the World Magnetic Model bent by the
vehicle's iron, the standard atmosphere above mean sea level with the scenario's errors of the barometer. To
them come errors as the ADIS16407's sheet has them: 0.066 mgauss/√Hz and a bias of 4 mgauss (1 σ of one draw
an axis) of the magnetometers, 0.027 mbar of the barometer.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import ImuWorld
from host.sim.errors.inertial_sensor import InertialSensor
from host.sim.seeding import generator
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE
from host.sim.truth import TruthBatch
from host.sim.vehicle_field import StaticPressure, VehicleField, attitude_matrices

Array = NDArray[np.float64]

FIELD_DENSITY = 0.066e-7
"""T/√Hz."""
FIELD_BIAS_T = 4.0e-7
PRESSURE_NOISE_PA = 2.7


class FeltTenDof:
    """Implements `boards.chips.world.TenDofWorld` on an inertial sensor and the truth of a drive."""

    def __init__(
        self,
        imu: ImuWorld,
        truth: Callable[[NDArray[np.int64]], TruthBatch],
        around: tuple[VehicleField, StaticPressure],
        mounting: Array,
        seed: int,
        name: str,
        *,
        perfect: bool = False,
    ) -> None:
        """`mounting` = C_b_s (3, 3): body = C_b_s sensor. `perfect`: nothing of the chip's own."""
        self._imu = imu
        self._truth = truth
        self._field, self._pressure = around
        self._c_bs = np.asarray(mounting, dtype=np.float64)
        self._noise = generator(seed, f"{name}.ten_dof.noise")
        self._gain = 0.0 if perfect else 1.0
        self._bias = self._gain * FIELD_BIAS_T * generator(seed, f"{name}.ten_dof.bias").standard_normal(3)

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> Array:
        """Force (3), rate (3), temperature, field (3), pressure at rising times."""
        values = np.empty((len(times_ns), 11))
        place, c_nb = self._feel_motion(times_ns, bandwidth_hz, values)
        noise = self._gain * self._noise.standard_normal((len(times_ns), 4))
        field = self._field.felt(self._field.true(place, c_nb)) @ self._c_bs
        field += self._bias
        field += FIELD_DENSITY * math.sqrt(bandwidth_hz) * noise[:, :3]
        values[:, 7:10] = field
        values[:, 10] = self._pressure.at(times_ns, place[2]) + PRESSURE_NOISE_PA * noise[:, 3]
        return values

    def _feel_motion(
        self, times_ns: NDArray[np.int64], bandwidth_hz: float, values: Array
    ) -> tuple[tuple[Array, Array, Array], Array]:
        """Fill the inertial sensor's columns; returns latitudes, longitudes, heights and C_n_b (n, 3, 3).

        A simulated sensor and its place come out of one look at the truth."""
        imu = self._imu
        if isinstance(imu, InertialSensor):
            times_ns = np.ascontiguousarray(times_ns, dtype=np.int64)
            rows = imu.road(times_ns)
            values[:, :7] = imu.measured(times_ns, rows, bandwidth_hz)
            place = rows[:, LATITUDE], rows[:, LONGITUDE], rows[:, HEIGHT]
            return place, rows[:, C_NB : C_NB + 9].reshape(-1, 3, 3)
        values[:, :7] = imu.sample(times_ns, bandwidth_hz)
        truth = self._truth(times_ns)
        return (truth.latitude, truth.longitude, truth.height), attitude_matrices(truth)
