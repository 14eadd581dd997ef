"""What lies between a sensor's element and its output: bandwidth, range, resolution.

A first-order low-pass of cut-off B on motion, errors and noise together, y ← y + (1 − e^(−2π B Δt)) (x − y);
then what lies beyond the range is cut off, and the rest is rounded to whole steps of the resolution. Chips of
boards do all that themselves; this is for sensors without a chip, and for elements that end before the chip.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from host.sim.compiled import Floats, entry
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
        self._memory = np.zeros((2, 3))
        self._last_ns = -1

    @property
    def changes(self) -> bool:
        """Whether it does anything."""
        parts = (*self._bandwidths, *self._limits, *self._steps)
        return any(value is not None for _, value in parts)

    def passed(self, times_ns: NDArray[np.int64], samples: Floats) -> None:
        """Change force (m/s²) and rate (rad/s) in rows (n, 7) at rising times in place."""
        for k, (columns, bandwidth_hz) in enumerate(self._bandwidths):
            if bandwidth_hz is not None:
                steps_s = np.diff(times_ns, prepend=self._last_ns) * 1e-9
                shares = -np.expm1(-2.0 * math.pi * bandwidth_hz * np.maximum(steps_s, 0.0))
                if self._last_ns < 0:
                    shares[0] = 1.0
                low_pass(shares, self._memory[k], samples[:, columns])
        self._last_ns = int(times_ns[-1])
        for columns, limit in self._limits:
            if limit is not None:
                np.clip(samples[:, columns], -limit, limit, out=samples[:, columns])
        for columns, step in self._steps:
            if step is not None:
                samples[:, columns] = np.round(samples[:, columns] / step) * step


def _in_si(value: float | None, unit: float) -> float | None:
    return None if value is None else value * unit


@entry
def low_pass(shares: Floats, memory: Floats, samples: Floats) -> None:
    """Filter three columns (n, 3) in place; `memory` (3) holds the last outputs."""
    for k in range(shares.shape[0]):
        for i in range(3):
            memory[i] += shares[k] * (samples[k, i] - memory[i])
            samples[k, i] = memory[i]
