"""What only recordings tell, and no frame of the link: inertial samples, and an attitude by itself."""

from __future__ import annotations

import math
from typing import NamedTuple


class Inertial(NamedTuple):
    """A sample in body axes, forward, right, down (of a run's own capture: in the chip's)."""

    time_us: int
    rates: tuple[float, float, float]
    """rad/s."""
    forces: tuple[float, float, float]
    """m/s²."""

    def completed_from(self, before: Inertial | None) -> Inertial:
        """Gyro and accelerometer may be recorded by turns: what is NaN here stays as it was."""
        if before is None:
            return self
        rates = self.rates if math.isfinite(self.rates[0]) else before.rates
        forces = self.forces if math.isfinite(self.forces[0]) else before.forces
        return Inertial(self.time_us, rates, forces)


class Attitude(NamedTuple):
    """Of a recording that has no position with it, rad."""

    time_us: int
    yaw: float
    pitch: float
    roll: float


INERTIAL = 0x200
ATTITUDE = 0x201
"""Kinds beside those of the link."""
