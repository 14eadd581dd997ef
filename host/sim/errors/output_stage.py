"""What lies between a sensor's element and its output: bandwidth, range, resolution.

A first-order low-pass of cut-off B on motion, errors and noise together, y ← y + (1 − e^(−2π B Δt)) (x − y);
then what lies beyond the range is cut off, and the rest is rounded to whole steps of the resolution. Chips of
boards do all that themselves; this is for sensors without a chip, and for elements that end before the chip.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import Floats, Integers, entry
from host.sim.errors.schema import ImuErrors

DEG = math.pi / 180.0
MILLI_G = 9.80665e-3
FORCE, RATE = slice(0, 3), slice(3, 6)


class OutputStage:
    """Of one sensor: the rows of its samples as they leave it."""

    def __init__(self, errors: ImuErrors) -> None:
        gyro, accelerometer = errors.gyro, errors.accelerometer
        self._bandwidths = [(FORCE, accelerometer.bandwidth_hz), (RATE, gyro.bandwidth_hz)]
        self._limits = [
            (FORCE, _in_si(accelerometer.range_g, 1e3 * MILLI_G)),
            (RATE, _in_si(gyro.range_dps, DEG)),
        ]
        self._steps = [
            (FORCE, _in_si(accelerometer.resolution_mg, MILLI_G)),
            (RATE, _in_si(gyro.resolution_dps, DEG)),
        ]
        self._memory = np.zeros(7)
        self._memory[6] = -1.0

    @property
    def changes(self) -> bool:
        """Whether it does anything."""
        parts = (*self._bandwidths, *self._limits, *self._steps)
        return any(value is not None for _, value in parts)

    def passed(self, times_ns: NDArray[np.int64], samples: Floats) -> None:
        """Change force (m/s²) and rate (rad/s) in rows (n, 7) at rising times in place."""
        cutoffs = np.zeros(6)
        for columns, bandwidth_hz in self._bandwidths:
            cutoffs[columns] = bandwidth_hz or 0.0
        if cutoffs.any():
            low_pass(times_ns, cutoffs, self._memory, samples)
        for columns, limit in self._limits:
            if limit is not None:
                np.clip(samples[:, columns], -limit, limit, out=samples[:, columns])
        for columns, step in self._steps:
            if step is not None:
                samples[:, columns] = np.round(samples[:, columns] / step) * step


def _in_si(value: float | None, unit: float) -> float | None:
    return None if value is None else value * unit


@entry
def low_pass(times_ns: Integers, cutoffs_hz: Floats, memory: Floats, samples: Floats) -> None:
    """Filter the first six columns; a cut-off of 0 leaves a column alone. `memory`: six outputs and the time
    of the last sample in s (negative: none)."""
    for k in range(times_ns.shape[0]):
        t = times_ns[k] * 1e-9
        for i in range(6):
            if cutoffs_hz[i] > 0.0:
                share = 1.0
                if memory[6] >= 0.0 and t > memory[6]:
                    share = 1.0 - math.exp(-2.0 * math.pi * cutoffs_hz[i] * (t - memory[6]))
                memory[i] += share * (samples[k, i] - memory[i])
                samples[k, i] = memory[i]
        memory[6] = t
