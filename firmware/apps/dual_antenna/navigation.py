"""The navigation task's memory and entry points: samples and epochs go in, the state is kept."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.apps.dual_antenna.settings import Settings
from firmware.apps.gnss_ins.navigation import NavigationState, StateKernels
from firmware.drivers import gnss_epoch as gnss
from firmware.nav import reference_layout as ref
from firmware.nav import reference_report as report
from firmware.nav.config import NavConfig, configure
from firmware.nav.full_combination import full_combination
from firmware.nav.reference_config import AttitudeReference
from firmware.numerics.dialect import entry_point
from firmware.numerics.precision import load

ALL_OF_ATTITUDE = ~(
    gnss.HAS_HEADING | gnss.HAS_PITCH | gnss.HAS_ROLL | gnss.HAS_ATTITUDE_ACCURACY | gnss.HAS_BASELINE
)
LEAST_LEVEL_M = 0.1
RATE_LIMIT = math.radians(500.0)
ACCEL_LIMIT = 30.0 * 9.80665
"""Ranges of the unit."""
REPEAT_RATE = 1.0e-6
REPEAT_FORCE = 4.0e-6
"""rad/s, m/s²: five and two units of an increment. The unit carries rounding on, so that one unchanged rate
comes as two numbers in turn, which float32 rounds again; noise is 200 and 1,200 units."""


class NavigationKernels(StateKernels):
    """The compiled code that navigation calls, in the profile's precision."""

    def __init__(self, precision: str) -> None:
        super().__init__(precision)
        self.sample_step = entry_point(load("firmware.apps.dual_antenna.steps", precision).sample_step)
        self.attitude_step = entry_point(load("firmware.nav.attitude_reference", precision).attitude_step)
        self.report = entry_point(load("firmware.nav.reference_report", precision).attitude_report)


class Navigation(NavigationState):
    """State and entry points; every method is one kernel call."""

    def __init__(self, kernels: NavigationKernels, config: NavConfig, uses_attitude: bool) -> None:
        super().__init__(kernels, config, ref.F_END, ref.I_END)
        self.kernels = kernels
        self._config = config
        self.samples_missed = 0
        self.samples_repeated = 0
        """The front end hands each over once."""
        self._uses_attitude = uses_attitude
        self._told_floats = np.zeros(report.ATTITUDE_FLOATS, kernels.real)
        self._told_integers = np.zeros(report.ATTITUDE_INTEGERS, np.int64)

    def begin_anew(self) -> None:
        """As after power-on."""
        configure(self.f, self.i, self._config)

    def take_epoch(self, epoch: NDArray[np.int64]) -> None:
        """One update of the filter: position and velocity, then attitude."""
        if not self._uses_attitude:
            epoch[gnss.FLAGS] &= ALL_OF_ATTITUDE
        self.kernels.gnss_step(self.f, self.i, epoch)
        self.kernels.attitude_step(self.f, self.i, epoch)

    def attitude_report(self) -> tuple[list[float], list[int]]:
        """What became of the receiver's attitude, as `firmware.nav.reference_report` lays it out."""
        self.kernels.report(self.f, self.i, self._told_floats, self._told_integers)
        return self._told_floats.tolist(), self._told_integers.tolist()


def nav_config(settings: Settings, installation: Mapping[str, Any]) -> NavConfig:
    """Navigation's configuration for a profile and an installation."""
    imu, receiver = installation["imu"], installation["gnss"]
    if "second_antenna_m" not in receiver:
        raise ValueError(
            "the receiver has one antenna; this program needs a second one, for example"
            " second_antenna_m = [1.0, 0.0, -1.2]"
        )
    lever = np.subtract(receiver["lever_arm_m"], imu["lever_arm_m"])
    baseline = np.subtract(receiver["second_antenna_m"], receiver["lever_arm_m"])
    if not np.hypot(baseline[0], baseline[1]) > LEAST_LEVEL_M:
        raise ValueError(
            f"second_antenna_m = {list(receiver['second_antenna_m'])} lies above or below the main antenna at"
            f" {list(receiver['lever_arm_m'])}; heading needs {LEAST_LEVEL_M} m between them that are level,"
            " for example second_antenna_m = [1.0, 0.0, -1.2]"
        )
    return full_combination(
        baseline=vector(baseline),
        attitude=AttitudeReference(baseline=vector(baseline), compass_time=settings.gyro_compass_s),
        C_b_s=tuple(float(element) for row in imu["C_b_s"] for element in row),
        antenna_lever_arm=vector(lever),
        two_sample=False,  # the unit's samples are means over their periods
        rate_limit=RATE_LIMIT,
        accel_limit=ACCEL_LIMIT,
        repeat_rate=REPEAT_RATE,
        repeat_force=REPEAT_FORCE,
    )


def vector(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Three numbers."""
    x, y, z = (float(value) for value in values)
    return x, y, z
