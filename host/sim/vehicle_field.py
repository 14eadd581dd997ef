"""The magnetic field as a magnetometer on the vehicle feels it, and the pressure as a barometer does.

    felt = soft iron · C_b_n m_n + hard iron + noise                           (body axes)

The iron is the vehicle's and the same for all its magnetometers, the noise is each one's. The pressure at sea
level, a barometer's bias, drift and noise are the scenario's. What a chip adds of its own is its affair.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.sim.atmosphere import STANDARD_HPA, standard_pressure
from host.sim.errors.ambient_schema import BarometerErrors, MagnetometerErrors
from host.sim.errors.processes import Process, ProcessBank
from host.sim.magnetic_field import MagneticField
from host.sim.seeding import generator
from host.sim.truth import TruthBatch

Floats = NDArray[np.float64]
MICRO = 1e-6


class VehicleField:
    """What is left of the Earth's field on board."""

    def __init__(self, field: MagneticField, errors: MagnetometerErrors, seed: int, name: str) -> None:
        """`name` of the magnetometer whose noise it has."""
        self._field = field
        self._sigma = MICRO * axes(errors.noise_ut)
        self.noise = [generator(seed, f"{name}_{axis}.noise") for axis in "xyz"]
        self._soft = np.array(errors.soft_iron)
        drawn = [generator(seed, f"mag_{axis}.hard_iron").standard_normal() for axis in "xyz"]
        self._hard = MICRO * (axes(errors.hard_iron_ut) + axes(errors.hard_iron_error_ut) * np.array(drawn))

    def true(self, place: tuple[Floats, Floats, Floats], c_nb: Floats) -> Floats:
        """(n, 3) in T, body axes, at latitudes, longitudes (rad), heights (m), attitudes C_n_b (n, 3, 3)."""
        return self._field.turned(place, c_nb)

    def felt(self, true: Floats) -> Floats:
        """What iron and noise make of it; to be asked for in order."""
        bent: Floats = true @ self._soft.T + self._hard
        if self._sigma.any():
            bent += self._sigma * np.column_stack([one.standard_normal(len(true)) for one in self.noise])
        return bent

    def on_board(self, truth: TruthBatch) -> Floats:
        """`felt` along a drive."""
        place = truth.latitude, truth.longitude, truth.height
        return self.felt(self.true(place, attitude_matrices(truth)))


class StaticPressure:
    """A barometer's errors beside its chip's own; to be asked for in rising times."""

    def __init__(self, errors: BarometerErrors, geoid_separation_m: float, seed: int, name: str) -> None:
        self._errors = errors
        self._separation = geoid_separation_m
        draw = float(generator(seed, f"{name}.bias").standard_normal())
        self._bias = errors.bias_pa + errors.bias_error_pa * draw
        self._drift = ProcessBank([Process(f"{name}.drift", errors.drift_pa, errors.drift_time_s)], seed)
        self._noise = generator(seed, f"{name}.noise")

    def at(self, times_ns: NDArray[np.int64], height: Floats) -> Floats:
        """Pa at heights above the ellipsoid."""
        pressure = standard_pressure(height - self._separation) * (self._errors.sea_level_hpa / STANDARD_HPA)
        pressure += self._bias
        if self._errors.drift_pa:
            pressure += self._drift.values(times_ns)[:, 0]
        if self._errors.noise_pa:
            pressure += self._errors.noise_pa * self._noise.standard_normal(len(times_ns))
        return pressure


def axes(value: float | list[float]) -> Floats:
    """One value an axis."""
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (3,)).copy()


def attitude_matrices(truth: TruthBatch) -> Floats:
    """C_n_b (n, 3, 3): from forward-right-down to north-east-down."""
    cy, sy = np.cos(truth.yaw), np.sin(truth.yaw)
    cp, sp = np.cos(truth.pitch), np.sin(truth.pitch)
    cr, sr = np.cos(truth.roll), np.sin(truth.roll)
    rows = (
        *(cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy),
        *(cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy),
        *(-sp, sr * cp, cr * cp),
    )
    return np.column_stack(rows).reshape(-1, 3, 3)
