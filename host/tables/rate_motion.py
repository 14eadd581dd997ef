"""Nine accelerometers on a rotation in closed form: what each of them feels at any time, with its errors.

    a = A + ω̇ × u + ω × (ω × u)
    ω(t) = r(t) (m + s sin(2π f t + p)) about each axis, r from 0 to 1 within 2 s

A is a force that turns and swings by some m/s², about gravity. Chips with clocks of their own are read at
200 Hz for their newest sample, as the acquisition does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware.nav.gyro_free.geometry import DIRECTIONS, POSITIONS
from host.sim.seeding import generator

Array = NDArray[np.float64]
G = 9.80665
PERIOD = 0.005
RAMP_S = 2.0
FREQUENCIES_HZ = (0.11, 0.17, 0.23)
PHASES = (0.3, 1.7, 2.9)
COUNT = 3.9e-3 * G
NOISE = (4.1e-3 * G,) * 8 + (6.1e-3 * G,)
"""ADXL345 at 200 Hz: 1.06 counts on x and y, 1.56 on z, which only the chip at the origin uses."""
CHIP_OF = (0, 1, 2, 3, 4, 5, 6, 6, 6)
CLOCK_TOLERANCE = 0.01


@dataclass(frozen=True, slots=True)
class Rotation:
    """Mean and amplitude of the rate about each axis, rad/s."""

    name: str
    mean: tuple[float, float, float]
    swing: tuple[float, float, float]

    def rates(self, times: Array) -> tuple[Array, Array]:
        """ω and ω̇ (n, 3) at times in s."""
        angle = np.pi * times / (2.0 * RAMP_S)
        rising = times < RAMP_S
        ramp = np.where(rising, np.sin(angle) ** 2, 1.0)[:, None]
        ramp_rate = np.where(rising, np.pi / (2.0 * RAMP_S) * np.sin(2.0 * angle), 0.0)[:, None]
        turn = 2.0 * np.pi * np.array(FREQUENCIES_HZ)
        phase = turn * times[:, None] + np.array(PHASES)
        steady = np.array(self.mean) + np.array(self.swing) * np.sin(phase)
        return ramp * steady, ramp * np.array(self.swing) * turn * np.cos(phase) + ramp_rate * steady


ROTATIONS = (
    Rotation("about x", (1.0, 0.0, 0.0), (0.5, 0.0, 0.0)),
    Rotation("about y", (0.0, 1.0, 0.0), (0.0, 0.5, 0.0)),
    Rotation("about z", (0.0, 0.0, 1.0), (0.0, 0.0, 0.5)),
    Rotation("about all axes", (1.0, -0.8, 1.2), (0.4, 0.4, 0.4)),
    Rotation("about all axes, through zero", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
)


@dataclass(frozen=True, slots=True)
class Sensors:
    """Which errors the accelerometers have."""

    name: str
    noisy: bool
    clocks: bool
    assumed_noise: float
    """What the methods are told, m/s²."""


SENSORS = (
    Sensors("ideal", False, False, 3.0e-7),
    Sensors("own clocks", False, True, 4.6e-3 * G),
    Sensors("ADXL345 noise", True, False, 4.6e-3 * G),
    Sensors("ADXL345 noise, own clocks", True, True, 4.6e-3 * G),
)


def felt(
    rotation: Rotation, sensors: Sensors, arm: float, duration_s: float, seed: int
) -> tuple[Array, Array]:
    """A1 … A9 (n, 9) in m/s² as read every 5 ms, and the true ω (n, 3) then."""
    ticks = PERIOD * np.arange(round(duration_s / PERIOD) + 1, dtype=np.float64)
    read = np.empty((len(ticks), 9))
    for place in range(9):
        read[:, place] = _one(rotation, place, arm, _sampled_at(ticks, sensors, place, seed))
        if sensors.noisy:
            noise = generator(seed, f"A{place + 1}.noise").standard_normal(len(ticks))
            read[:, place] = np.round((read[:, place] + NOISE[place] * noise) / COUNT) * COUNT
    return read, rotation.rates(ticks)[0]


def _one(rotation: Rotation, place: int, arm: float, times: Array) -> Array:
    rate, change = rotation.rates(times)
    u = arm * np.array(POSITIONS[place])
    force = np.column_stack((3.0 * np.sin(0.3 * times), 2.0 * np.cos(0.2 * times), np.full(len(times), -G)))
    acceleration = force + np.cross(change, u) + np.cross(rate, np.cross(rate, u))
    return np.asarray(acceleration[:, DIRECTIONS[place]], np.float64)


def _sampled_at(ticks: Array, sensors: Sensors, place: int, seed: int) -> Array:
    """When the newest sample at each tick was taken: at the tick, or by the chip's own clock."""
    if not sensors.clocks:
        return ticks
    drawn = generator(seed, f"chip{CHIP_OF[place]}.clock").uniform(-1.0, 1.0, 2)
    period = PERIOD / (1.0 + CLOCK_TOLERANCE * drawn[0])
    begun = -0.5 * (drawn[1] + 1.0) * period
    return np.asarray(np.maximum(begun + np.floor((ticks - begun) / period) * period, 0.0), np.float64)
