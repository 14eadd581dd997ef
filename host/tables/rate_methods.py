"""The four methods of the angular rate on one rotation after another: RMS error over time and seeds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware.nav.gyro_free import layout as at
from firmware.nav.gyro_free.config import GyroFreeConfig, new_sensor
from firmware.nav.gyro_free.rates import rate_step
from firmware.numerics.dialect import entry_point
from host.tables.rate_motion import PERIOD, ROTATIONS, SENSORS, Rotation, Sensors, felt

Array = NDArray[np.float64]
METHODS = at.METHOD_NAMES
FUSED = "fused"
ALLOWED = 1.05
"""How much worse than the best of the document's three the fused rate may be."""


@dataclass(frozen=True, slots=True)
class RateRow:
    """One rotation with one kind of sensors."""

    rotation: str
    sensors: str
    error: dict[str, float]
    """RMS of all three axes, rad/s, by method; infinite when a number was none."""
    must_win: bool
    """The fused rate has to be the best, not only as good."""

    @property
    def best_of_three(self) -> float:
        """Of the document's methods, rad/s."""
        return min(error for method, error in self.error.items() if method != FUSED)

    @property
    def met(self) -> bool:
        """Whether the fused rate is as good as wanted."""
        if self.must_win:
            return self.error[FUSED] < self.best_of_three
        return self.error[FUSED] <= ALLOWED * self.best_of_three


def rate_rows(arm: float, duration_s: float, seeds: Sequence[int]) -> Iterator[RateRow]:
    """Every kind of sensors on every rotation."""
    for sensors in SENSORS:
        for rotation in ROTATIONS:
            yield rate_row(rotation, sensors, arm, duration_s, seeds)


def rate_row(
    rotation: Rotation, sensors: Sensors, arm: float, duration_s: float, seeds: Sequence[int]
) -> RateRow:
    """All methods on the same samples."""
    random = sensors.noisy or sensors.clocks
    squares: dict[str, list[float]] = {method: [] for method in METHODS}
    for seed in seeds if random else seeds[:1]:
        read, truth = felt(rotation, sensors, arm, duration_s, seed)
        for method in METHODS:
            off = rates(method, read, arm, sensors.assumed_noise) - truth
            square = float(np.mean(off * off))
            squares[method].append(square if np.isfinite(square) else np.inf)
    error = {method: float(np.sqrt(np.mean(values))) for method, values in squares.items()}
    every_axis = all(rotation.swing)
    return RateRow(rotation.name, sensors.name, error, sensors.noisy and every_axis)


def rates(method: str, read: Array, arm: float, noise: float) -> Array:
    """ω (n, 3) that the kernel makes of accelerations (n, 9), starting from rest."""
    config = GyroFreeConfig(
        arm_length=arm, method=method, acceleration_noise=noise, initial_rate_sigma=1.0e-5
    )
    g, n = new_sensor(config)
    step = entry_point(rate_step)
    samples = read.astype(np.float32)
    made = np.empty((len(read), 3))
    sample, rate = g[at.ACCELERATION : at.ACCELERATION + 9], g[at.OMEGA : at.OMEGA + 3]
    for row in range(len(samples)):
        sample[:] = samples[row]
        step(g, n, PERIOD)
        made[row] = rate
    return made
