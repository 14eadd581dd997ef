"""The compiled code of one arithmetic: what is in flash."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.apps.uav_ahrs import fixed_steps
from firmware.apps.uav_ahrs.fixed_disagreement import RAD_PER_S
from firmware.apps.uav_ahrs.fixed_holding import FIXED_HOLDING_SIZE
from firmware.apps.uav_ahrs.holding import HOLDING_SIZE
from firmware.nav.attitude.config import AttitudeConfig, configure
from firmware.nav.attitude.fixed import loop as fixed_loop
from firmware.nav.attitude.fixed.config import configure as configure_fixed
from firmware.nav.drift.fixed.settings import new_state as new_fixed_state
from firmware.nav.drift.settings import DriftSettings, new_state
from firmware.numerics.dialect import entry_point
from firmware.numerics.precision import load


class AttitudeKernels:
    """Entry kernels of the attitude computer. ValueError for an arithmetic that does not exist."""

    def __init__(self, arithmetic: str, compensated: bool) -> None:
        """`compensated`: the drift compensation follows each iteration."""
        fixed = arithmetic == "fixed"
        self.dtype: Any = np.dtype("int32" if fixed else arithmetic)
        steps = fixed_steps if fixed else load("firmware.apps.uav_ahrs.steps", arithmetic)
        loop = fixed_loop if fixed else load("firmware.nav.attitude.loop", arithmetic)
        self.configure = configure_fixed if fixed else configure
        self.take_burst = entry_point(steps.take_burst)
        self.iteration = entry_point(steps.corrected_iteration if compensated else steps.iteration)
        """(s, i, before, …), what follows as `new_drift` gives it."""
        self.solution = entry_point(loop.solution)
        self.correction_unit = RAD_PER_S if fixed else 1.0
        """rad/s of a count that `disagreement` keeps."""
        self._compensated = compensated
        self._fixed = fixed

    def new_drift(self, config: AttitudeConfig) -> tuple[NDArray[Any], ...]:
        """Memory of the drift compensation; nothing without it."""
        if not self._compensated:
            return ()
        settings = DriftSettings(
            rate_range=math.radians(config.gyro_range_dps), declination=config.declination
        )
        if self._fixed:
            return (*new_fixed_state(config.period, settings), np.zeros(FIXED_HOLDING_SIZE, np.int64))
        return (*new_state(settings, self.dtype), np.zeros(HOLDING_SIZE, self.dtype))
