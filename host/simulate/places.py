"""Where sensors sit along a trajectory from a file."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Places:
    """Where things sit, from the trajectory's points on in body axes, m; C_b_s of the inertial sensor."""

    antenna_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sensor_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mounting_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Yaw, pitch, roll of the sensor's axes against the body's."""


AT_ORIGIN = Places()
