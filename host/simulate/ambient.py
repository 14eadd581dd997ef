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
from host.sim.atmosphere import pressure_height
from host.sim.errors.ambient_schema import BarometerErrors, MagnetometerErrors
from host.sim.magnetic_field import MagneticField
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE
from host.sim.vehicle_field import MICRO, StaticPressure, VehicleField
from host.simulate.instants import NS

Floats = NDArray[np.float64]


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
        self._field = VehicleField(field, errors, seed, "mag")

    def rows(self, times_ns: NDArray[np.int64], truth: Floats) -> Floats:
        """See `AmbientSensor`."""
        place = truth[:, LATITUDE], truth[:, LONGITUDE], truth[:, HEIGHT]
        true = self._field.true(place, truth[:, C_NB : C_NB + 9].reshape(-1, 3, 3))
        return np.column_stack((times_ns / NS, self._field.felt(true) / MICRO, true / MICRO))


class Barometer:
    """Static pressure."""

    name = "baro"
    table = Table(("t_s", "pressure_pa", "pressure_height_m", "true_height_msl_m"), (9, 3, 4, 4))

    def __init__(self, errors: BarometerErrors, geoid_separation_m: float, seed: int) -> None:
        self._separation = geoid_separation_m
        self._pressure = StaticPressure(errors, geoid_separation_m, seed, "baro")

    def rows(self, times_ns: NDArray[np.int64], truth: Floats) -> Floats:
        """See `AmbientSensor`."""
        pressure = self._pressure.at(times_ns, truth[:, HEIGHT])
        height = truth[:, HEIGHT] - self._separation
        return np.column_stack((times_ns / NS, pressure, pressure_height(pressure), height))
