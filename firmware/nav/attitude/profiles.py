"""The attitude computer in one arithmetic, behind one set of doors.

loop = load_loop("float32")
s, i, out = loop.new_state(AttitudeConfig(latitude=0.8))
loop.take_words(s, i, words); loop.take_words(s, i, words); loop.iterate(s, i); loop.solution(s, i, out)
"""

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude import config as float_config
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.fixed import config as fixed_config
from firmware.nav.attitude.fixed import loop as fixed_loop
from firmware.numerics.precision import load

PROFILES: Final = ("float32", "fixed", "float64")


@dataclass(frozen=True, slots=True)
class AttitudeLoop:
    """Entry kernels of one arithmetic (see loop.py), its arrays and its way of writing samples."""

    profile: str
    dtype: Any
    """Of the array `s`."""
    configure: Callable[[NDArray[Any], NDArray[np.int64], float_config.AttitudeConfig], None]
    take_words: Callable[[NDArray[Any], NDArray[np.int64], NDArray[np.int64]], int]
    take_rates: Callable[[NDArray[Any], NDArray[np.int64], NDArray[Any]], int]
    bridge: Callable[[NDArray[Any], NDArray[np.int64]], int]
    iterate: Callable[[NDArray[Any], NDArray[np.int64]], int]
    solution: Callable[[NDArray[Any], NDArray[np.int64], NDArray[np.int64]], None]
    samples: Callable[[NDArray[np.float64]], NDArray[Any]]
    """ω (rad/s), f (m/s²), m (T) in rows of 9, float64, as `take_rates` wants them."""

    def new_state(
        self, config: float_config.AttitudeConfig
    ) -> tuple[NDArray[Any], NDArray[np.int64], NDArray[np.int64]]:
        """`s` and `i`, configured, and a record for `solution`."""
        s = np.zeros(at.S_SIZE, self.dtype)
        i = np.zeros(at.I_SIZE, np.int64)
        self.configure(s, i, config)
        return s, i, np.zeros(at.OUT_SIZE, np.int64)


def load_loop(profile: str) -> AttitudeLoop:
    """The loop of an arithmetic; ValueError for one that is not known."""
    if profile not in PROFILES:
        raise ValueError(f"profile {profile!r} is not known; one of {', '.join(PROFILES)}")
    if profile == "fixed":
        return _loop(profile, fixed_loop, np.dtype(np.int32), fixed_config.configure, fixed_config.samples)
    dtype = np.dtype(profile)
    module = load("firmware.nav.attitude.loop", profile)
    return _loop(profile, module, dtype, float_config.configure, lambda rows: np.asarray(rows, dtype))


def _loop(profile: str, module: ModuleType, dtype: Any, configure: Any, samples: Any) -> AttitudeLoop:
    return AttitudeLoop(
        profile,
        dtype,
        configure,
        module.take_words,
        module.take_rates,
        module.bridge,
        module.iterate,
        module.solution,
        samples,
    )
