"""Magnetometer and barometer at the vehicle's origin, axes of the body, sampled at rates of their own.

Barometer: the standard atmosphere (`host.sim.atmosphere`) with the scenario's pressure at sea level; the
height beside a pressure is that of the atmosphere with 1013.25 hPa.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from host.record.tables import Table
from host.sim.atmosphere import STANDARD_HPA, pressure_height, standard_pressure
from host.sim.errors.ambient_schema import BarometerErrors, MagnetometerErrors
from host.sim.errors.processes import Process, ProcessBank
from host.sim.magnetic_field import MagneticField
from host.sim.seeding import generator
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE
from host.simulate.instants import NS

Floats = NDArray[np.float64]

MICRO = 1e-6


class AmbientSensor(Protocol):
    """What is written as a file or member of its own."""

    @property
    def name(self) -> str:
        """Of the file, member or topic."""
        ...

    @property
    def table(self) -> Table:
        """Its columns."""
        ...

    def rows(self, times_ns: NDArray[np.int64], truth: Floats) -> Floats:
        """Rows of the table at the next instants, whose truth (n, 24) is known."""
        ...


@dataclass(frozen=True, slots=True)
class Ambient:
    """A sensor and its rate."""

    sensor: AmbientSensor
    rate_hz: Fraction


class Magnetometer:
    """Three axes, µT."""

    name = "mag"
    table = Table(
        (
            "t_s",
            *(f"field_{axis}_ut" for axis in "xyz"),
            *(f"true_field_{axis}_ut" for axis in "xyz"),
        ),
        (9, *(6,) * 6),
    )

    def __init__(self, errors: MagnetometerErrors, field: MagneticField, seed: int) -> None:
        self._field = field
        self._soft = np.array(errors.soft_iron)
        self._hard = _axes(errors.hard_iron_ut) + _axes(errors.hard_iron_error_ut) * np.array(
            [generator(seed, f"mag_{axis}.hard_iron").standard_normal() for axis in "xyz"]
        )
        self._sigma = _axes(errors.noise_ut)
        self._noise = [generator(seed, f"mag_{axis}.noise") for axis in "xyz"]

    def rows(self, times_ns: NDArray[np.int64], truth: Floats) -> Floats:
        """See `AmbientSensor`."""
        field_n = self._field.at(truth[:, LATITUDE], truth[:, LONGITUDE], truth[:, HEIGHT]) / MICRO
        c_nb = truth[:, C_NB : C_NB + 9].reshape(-1, 3, 3)
        field_b = np.einsum("kij,ki->kj", c_nb, field_n)
        noise = np.column_stack([one.standard_normal(len(times_ns)) for one in self._noise])
        felt = field_b @ self._soft.T + self._hard + self._sigma * noise
        return np.column_stack((times_ns / NS, felt, field_b))


class Barometer:
    """Static pressure."""

    name = "baro"
    table = Table(("t_s", "pressure_pa", "pressure_height_m", "true_height_msl_m"), (9, 3, 4, 4))

    def __init__(self, errors: BarometerErrors, geoid_separation_m: float, seed: int) -> None:
        self._errors = errors
        self._separation = geoid_separation_m
        draw = float(generator(seed, "baro.bias").standard_normal())
        self._bias = errors.bias_pa + errors.bias_error_pa * draw
        self._drift = ProcessBank([Process("baro.drift", errors.drift_pa, errors.drift_time_s)], seed)
        self._noise = generator(seed, "baro.noise")

    def rows(self, times_ns: NDArray[np.int64], truth: Floats) -> Floats:
        """See `AmbientSensor`."""
        height = truth[:, HEIGHT] - self._separation
        pressure = standard_pressure(height) * (self._errors.sea_level_hpa / STANDARD_HPA)
        pressure += self._bias + self._drift.values(times_ns)[:, 0]
        pressure += self._errors.noise_pa * self._noise.standard_normal(len(times_ns))
        return np.column_stack((times_ns / NS, pressure, pressure_height(pressure), height))


def _axes(value: float | list[float]) -> Floats:
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (3,)).copy()
