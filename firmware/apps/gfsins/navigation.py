"""The federation as the DSP holds it: configuration for a profile, and the master as the board's solution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins.settings import Settings
from firmware.apps.gnss_ins.navigation import NavigationState, StateKernels
from firmware.nav import layout
from firmware.nav import solution as record
from firmware.nav.config import NavConfig
from firmware.nav.flags import NAVIGATING
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.config import GyroFreeConfig
from firmware.nav.gyro_free.filters import (
    DEG,
    Beginning,
    FilterConfig,
    adxl345_filters,
    begin,
    new_federation,
)
from firmware.nav.gyro_free.packet_door import PacketDoor
from hal.machine_code import mypyc_attr

POSITION_NOISE, HEIGHT_NOISE = 10.0, 10.0
MODE: Final[int] = layout.MODE
VELOCITY: Final[int] = layout.VELOCITY
LEAST_MODE: Final[int] = NAVIGATING


@mypyc_attr(allow_interpreted_subclasses=True)
class Navigation(NavigationState):
    """Filters side by side; `f` and `i` are the master's."""

    def __init__(self, kernels: StateKernels, config: FilterConfig) -> None:
        self.config = config
        self.federation = new_federation(config)
        f, i = self.federation.master
        super().__init__(kernels, NavConfig(), f.size, i.size)
        self.f, self.i = f, i
        self._numbers, self._integers = f.data, i.data
        """The same memory: a number of it in a fifth of the time."""
        self.door = PacketDoor(self.federation)
        self.flags_of: Callable[[int], int] | None = None
        """Flags of a solution from those of the master, which has no measurements of its own."""
        self.samples_missed = 0
        self.samples_repeated = 0

    def fill_solution(self) -> None:
        """The master's, with flags that know the sensors."""
        super().fill_solution()
        if self.flags_of is not None:
            known = int(self.integers[record.FLAGS]) if self.is_navigating else 0
            self.integers[record.FLAGS] = self.flags_of(known)

    def start(self, start: Beginning, certainty: Mapping[str, Any] | None = None) -> None:
        """Navigate from there; `certainty`: initial 1 σ that differ from those of the configuration."""
        begin(self.federation, replace(self.config, **(certainty or {})), start)

    def forget(self) -> None:
        """Begin anew, as after power-on."""
        held, fresh = self.federation, new_federation(self.config)
        for old, new in zip((held.g, held.n, *held.all), (fresh.g, fresh.n, *fresh.all), strict=True):
            old[:] = new

    @property
    def has_state(self) -> bool:
        """Whether the master navigates on numbers."""
        mode: int = self._integers[MODE]
        velocity: float = self._numbers[VELOCITY]
        return mode >= LEAST_MODE and velocity - velocity == 0.0

    def begin_again(self, tick_ns: int) -> bool:
        """The master has lost its state: all begin with that of a filter that has not. False: none has."""
        for f, i in (self.federation.gps, self.federation.compass):
            if int(i[layout.MODE]) >= NAVIGATING and np.all(np.isfinite(f[: layout.ACCEL_BIAS + 3])):
                self._solution(f, i, self.floats, self.integers)
                self._renew(f[layout.GYRO_BIAS : layout.ACCEL_BIAS + 3].copy(), tick_ns)
                return True
        return False

    def _renew(self, biases: NDArray[Any], tick_ns: int) -> None:
        """Fresh arrays but for what calibration and alignment have found, begun with the solution record."""
        held, values = self.federation, self.floats.tolist()
        sensor, counts = held.g[: gl.COMPASS_VARIANCE].copy(), held.n[: gl.MODE].copy()
        self.forget()
        held.g[: gl.COMPASS_VARIANCE], held.n[: gl.MODE] = sensor, counts
        north, east, down = values[record.VELOCITY : record.VELOCITY + 3]
        place = int(self.integers[record.LAT_NANODEG]), int(self.integers[record.LON_NANODEG])
        angles = values[record.YAW], values[record.PITCH], values[record.ROLL]
        self.start(Beginning(tick_ns, *place, values[record.HEIGHT], (north, east, down), angles))
        for f, _ in (held.compass, held.gps, held.master):
            f[layout.GYRO_BIAS : layout.ACCEL_BIAS + 3] = biases

    def memory(self) -> bytes:
        """All filters as they lie in memory."""
        federation = self.federation
        arrays = (federation.g, federation.n, *federation.all)
        return b"".join(array.tobytes() for array in arrays)


def filter_config(settings: Settings, installation: Mapping[str, Any]) -> FilterConfig:
    """Noise and reset mode for a profile, the arm's length from where the chips sit. Raises ValueError."""
    sensor = GyroFreeConfig(
        arm_length=arm_length(installation),
        method=settings.method,
        declination=math.radians(settings.declination_deg),
    )
    begun: dict[str, Any] = {
        "sigma_position": 15.0,
        "sigma_velocity": 0.5,
        "sigma_tilt": 0.5 * DEG,
        "sigma_yaw": 1.5 * DEG,
        "position_noise": (POSITION_NOISE, HEIGHT_NOISE),
    }
    if settings.feed == "adxl345":
        return adxl345_filters(sensor, settings.reset, **begun)
    return FilterConfig(reset=settings.reset, sensor=sensor, **begun)


def arm_length(installation: Mapping[str, Any]) -> float:
    """That of the six arms, which the method needs to be alike. Raises ValueError."""
    wanted = ((0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 0, -1), (-1, 0, 0), (0, -1, 0))
    origin = installation["accelerometer7"]["lever_arm_m"]
    length = 0.0
    for k, direction in enumerate(wanted):
        place = installation[f"accelerometer{k + 1}"]["lever_arm_m"]
        arm = [there - here for there, here in zip(place, origin, strict=True)]
        along = sum(a * d for a, d in zip(arm, direction, strict=True))
        length = length or along
        off = [a - length * d for a, d in zip(arm, direction, strict=True)]
        if length <= 0.0 or max(map(abs, off)) > 1e-6:
            raise ValueError(
                f"accelerometer{k + 1} sits at {list(place)}; it belongs at one arm's length along"
                f" {list(direction)} from accelerometer7, for example {[0.25 * d for d in direction]}"
            )
    return length
