"""The compiled code of one arithmetic: what is in flash."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude.config import AttitudeConfig, configure
from firmware.nav.drift.settings import DriftSettings, new_state
from firmware.numerics.dialect import entry_point
from firmware.numerics.precision import load


class AttitudeKernels:
    """Entry kernels of the attitude computer. ValueError for an arithmetic that does not exist."""

    def __init__(self, arithmetic: str) -> None:
        self.dtype: Any = np.dtype(arithmetic)
        steps = load("firmware.apps.uav_ahrs.steps", arithmetic)
        self.configure = configure
        self.take_burst = entry_point(steps.take_burst)
        self.iteration = entry_point(steps.iteration)
        self.solution = entry_point(load("firmware.nav.attitude.loop", arithmetic).solution)
        self.correct = entry_point(load("firmware.nav.drift.correction", arithmetic).correct)

    def new_drift(self, config: AttitudeConfig) -> tuple[NDArray[Any], NDArray[np.int64]]:
        """Memory of the drift compensation."""
        settings = DriftSettings(
            rate_range=math.radians(config.gyro_range_dps), declination=config.declination
        )
        return new_state(settings, self.dtype)
