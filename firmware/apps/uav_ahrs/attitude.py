"""The attitude computer of the board: its memory, and the kernels of the chosen arithmetic.

Bursts go in one by one; when three samples wait (the last of one iteration begins the next), an iteration
carries attitude, velocity and position over 8 ms, and the drift compensation follows it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.apps.uav_ahrs import plausibility as memory
from firmware.apps.uav_ahrs.holding import CORRECTION
from firmware.apps.uav_ahrs.kernels import AttitudeKernels
from firmware.apps.uav_ahrs.settings import Settings
from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.burst_words import WORDS
from firmware.nav.attitude.config import AttitudeConfig

MOVING_RATE, MOVING_FORCE = math.radians(90.0), 12.0
"""rad/s and m/s² that alignment in motion puts up with."""


class Attitude:
    """State and entry points; every method is one kernel call."""

    def __init__(self, kernels: AttitudeKernels, config: AttitudeConfig) -> None:
        self.s: NDArray[Any] = np.zeros(at.S_SIZE, kernels.dtype)
        self.i: NDArray[np.int64] = np.zeros(at.I_SIZE, np.int64)
        self.k: NDArray[np.int64] = np.zeros(memory.PLAUSIBILITY_SIZE, np.int64)
        """Of the plausibility of bursts."""
        self.record: NDArray[np.int64] = np.zeros(at.OUT_SIZE, np.int64)
        self._before: NDArray[Any] = np.zeros(at.S_SIZE, kernels.dtype)
        self.burst_words: NDArray[np.int64] = np.zeros(WORDS, np.int64)
        """Of the burst read last."""
        kernels.configure(self.s, self.i, config)
        self._kernels = kernels
        self._config = config
        self._before[:] = self.s
        self.take_burst: Callable[..., int] = kernels.take_burst
        """What `burst_memory` holds: a burst as the driver has it; returns what was noticed, and READY."""
        self._iteration: Callable[..., int] = kernels.iteration
        self._solution = kernels.solution
        self._drift = kernels.new_drift(config)
        self._iteration_memory = (self.s, self.i, self._before, *self._drift)
        self._correction_unit = kernels.correction_unit

    @property
    def is_aligning(self) -> bool:
        """Whether there is no attitude yet."""
        return int(self.i[at.MODE]) != fl.RUNNING

    def align_in_motion(self) -> None:
        """Begin to align anew without asking for rest: a second of force and field, and what the drift
        compensation makes of it. (A processor that starts again in flight will never find rest.)"""
        if self._drift:
            moving = replace(self._config, alignment_time=1.0, rest_rate=MOVING_RATE, rest_force=MOVING_FORCE)
            self._kernels.configure(self.s, self.i, moving)

    def iterate(self) -> int:
        """An iteration; returns 1, 0 or `steps.SPOILT`."""
        iteration = self._iteration
        return iteration(*self._iteration_memory)

    def burst_memory(self, raw: NDArray[np.uint8]) -> tuple[NDArray[Any], ...]:
        """What `take_burst` is called with for the bursts that come in `raw`."""
        return self.s, self.i, self.k, raw, self.burst_words

    def solve(self) -> NDArray[np.int64]:
        """The record of the present state (`layout.OUT_…`); what was noticed before is forgotten."""
        solution = self._solution
        solution(self.s, self.i, self.record)
        return self.record

    def notices(self) -> list[int]:
        """How often each bit of `flags` was noticed."""
        counted: list[int] = self.i[at.NOTICES : at.NOTICES + len(fl.NOTICE_NAMES)].tolist()
        return counted

    def saturations(self) -> list[int]:
        """Of the arithmetic in fixed point, by kind."""
        counted: list[int] = self.i[at.SATURATIONS : at.SATURATIONS + len(fl.SATURATION_NAMES)].tolist()
        return counted

    def still_reads(self) -> list[int]:
        """For how many reads gyro, accelerometer and magnetometer have shown exactly the same."""
        counted: list[int] = self.k[memory.STILL : memory.STILL + 3].tolist()
        return counted

    def disagreement(self) -> float:
        """At which rate force and field correct the gyros, rad/s; 0 without the drift compensation."""
        if not self._drift:
            return 0.0
        mean = self._drift[2][CORRECTION : CORRECTION + 3].tolist()
        return math.hypot(*mean) * self._correction_unit

    def forces_held(self) -> int:
        """Bursts whose force was out of range."""
        return int(self.k[memory.FORCES_HELD])

    @property
    def words(self) -> list[int]:
        """Of the burst read last, as they came."""
        told: list[int] = self.burst_words.tolist()
        return told

    def spoil(self) -> None:
        """Leave behind what is no attitude."""
        self.s[at.QUATERNION : at.QUATERNION + 4] = np.nan if self.s.dtype.kind == "f" else 0

    def memory(self) -> bytes:
        """All of it, as it lies there."""
        drift = b"".join(array.tobytes() for array in self._drift)
        return self.s.tobytes() + self.i.tobytes() + self.k.tobytes() + drift


def attitude_config(settings: Settings, installation: Mapping[str, Any]) -> AttitudeConfig:
    """The attitude computer's configuration for a profile and an installation."""
    rad = math.radians
    return AttitudeConfig(
        latitude=rad(settings.latitude_deg),
        longitude=rad(settings.longitude_deg),
        height=settings.height_m,
        method=settings.update,
        drift_compensation=settings.drift_compensation,
        alignment_time=settings.alignment_s,
        magnetometer=settings.magnetometer and settings.initial_yaw_deg is None,
        declination=rad(settings.declination_deg),
        yaw=rad(settings.initial_yaw_deg or 0.0),
        C_b_s=tuple(float(one) for row in installation["imu"]["C_b_s"] for one in row),
    )
