"""The navigation task: samples and GNSS epochs go in, the state of the vehicle is kept."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.apps.car_mems.sample_clock import CLOCK_SIZE, MISSED, REPEATED, reset_clock
from firmware.apps.car_mems.settings import Settings
from firmware.apps.car_mems.steps import APP_SIZE, CLOCK_AT, MEAN_AT
from firmware.apps.gnss_ins.navigation import NavigationState, StateKernels
from firmware.drivers.bmi160_sample import METRE_PER_S2_PER_LSB, RAD_PER_LSB, RANGE_END
from firmware.nav.config import NavConfig
from firmware.numerics.dialect import entry_point
from firmware.numerics.precision import load

MEAN_PERIOD = 0.1


class NavigationKernels(StateKernels):
    """The compiled code that navigation calls, in the profile's precision: what is in flash."""

    def __init__(self, precision: str) -> None:
        super().__init__(precision)
        self._steps = load("firmware.apps.car_mems.steps", precision)
        self.temperature_step = entry_point(load("firmware.nav.temperature", precision).temperature_step)

    @functools.cached_property
    def data_ready_step(self) -> Callable[..., int]:
        """The step of profile `full-rate`; only the one in use is compiled."""
        return entry_point(self._steps.data_ready_step)

    @functools.cached_property
    def timer_sample(self) -> Callable[..., int]:
        """The step of profile `thesis`."""
        return entry_point(self._steps.timer_sample)


class Navigation(NavigationState):
    """State and entry points. Behind what navigation needs, `i` also holds the sample clock and `f` the
    ten-sample mean."""

    def __init__(self, kernels: NavigationKernels, config: NavConfig) -> None:
        super().__init__(kernels, config, int(MEAN_AT) + APP_SIZE, int(CLOCK_AT) + CLOCK_SIZE)
        reset_clock(self.i, CLOCK_AT)
        self.kernels = kernels

    def sample_step(self, mean: bool) -> Callable[..., int]:
        """The kernel that takes a sample: (f, i, burst, board time of the read)."""
        return self.kernels.timer_sample if mean else self.kernels.data_ready_step

    def take_epoch(self, epoch: NDArray[np.int64], _pulse: tuple[int, int]) -> None:
        """One Kalman update; `_pulse`: the edge of TIMEPULSE that dated the epoch (count, ns)."""
        self.kernels.gnss_step(self.f, self.i, epoch)

    def take_temperature(self, celsius: float) -> None:
        """The inertial sensor has this temperature."""
        self.kernels.temperature_step(self.f, self.i, celsius)

    @property
    def samples_missed(self) -> int:
        """Samples of the chip that were never read."""
        return int(self.i[CLOCK_AT + MISSED])

    @property
    def samples_repeated(self) -> int:
        """Samples of the chip that were read twice."""
        return int(self.i[CLOCK_AT + REPEATED])

    def restart_sample_clock(self) -> None:
        """The chip was reset: its sensortime begins anew."""
        reset_clock(self.i, CLOCK_AT)


def nav_config(settings: Settings, installation: Mapping[str, Any], pulse_wired: bool) -> NavConfig:
    """Navigation's configuration for a profile and an installation.

    Lever arms are measured from the vehicle's origin, the point that does not slip sideways. Position follows
    the receiver within 2.5 epochs at any rate: errors of epochs that come quicker are more alike.
    """
    mounting = installation["imu"]["C_b_s"]
    sensor = installation["imu"]["lever_arm_m"]
    lever = np.subtract(installation["gnss"]["lever_arm_m"], sensor)
    mean = settings.strapdown == "mean"
    choices: dict[str, Any] = {"sample_period": MEAN_PERIOD, "two_sample": False} if mean else {}
    if settings.initial_yaw_deg is not None:
        choices["initial_yaw"] = math.radians(settings.initial_yaw_deg)
    if pulse_wired:
        choices["latency_sigma"] = 0.0
    return NavConfig(
        C_b_s=tuple(float(element) for row in mounting for element in row),
        antenna_lever_arm=(float(lever[0]), float(lever[1]), float(lever[2])),
        constraint_lever_arm=(-sensor[0], -sensor[1], -sensor[2]),
        constraint=settings.aiding,
        standstill=settings.aiding,
        position_walk=NavConfig.position_walk * settings.gnss_rate_hz,
        rate_limit=float(RANGE_END * RAD_PER_LSB),
        accel_limit=float(RANGE_END * METRE_PER_S2_PER_LSB),
        **choices,
    )
