"""The memory of navigation, and what is read out of it for the output.

Its memory is two flat arrays, `f` and `i`, laid out by `firmware.nav.layout`; what a program keeps beside
navigation lies behind.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav import layout
from firmware.nav import solution as record
from firmware.nav.config import NavConfig, configure
from firmware.nav.flags import NAVIGATING
from firmware.numerics.dialect import entry_point
from firmware.numerics.precision import load
from hal.machine_code import mypyc_attr


@mypyc_attr(allow_interpreted_subclasses=True)
class StateKernels:
    """The compiled code that every program with navigation calls, in the profile's precision."""

    def __init__(self, precision: str) -> None:
        solution = load("firmware.nav.solution", precision)
        self.real = np.dtype(precision)
        self.gnss_step = entry_point(load("firmware.nav.gnss", precision).gnss_step)
        self.solution = entry_point(solution.solution)
        self.covariance = entry_point(solution.covariance)
        self.innovation = entry_point(solution.innovation)
        self.biases = entry_point(solution.biases)


@mypyc_attr(allow_interpreted_subclasses=True)
class NavigationState:
    """State and what is told of it; every method is one kernel call."""

    def __init__(self, kernels: StateKernels, config: NavConfig, floats: int, integers: int) -> None:
        """`floats`, `integers`: lengths of the arrays."""
        real = kernels.real
        self.f: NDArray[Any] = np.zeros(floats, real)
        self.i: NDArray[np.int64] = np.zeros(integers, np.int64)
        configure(self.f, self.i, config)
        self._solution = kernels.solution
        self._state_kernels = kernels
        self.floats = np.zeros(record.SOLUTION_FLOATS, real)
        self.integers = np.zeros(record.SOLUTION_INTEGERS, np.int64)
        self._covariance_out = np.zeros(record.COVARIANCE_FLOATS, real)
        self._innovation_out = np.zeros(record.INNOVATION_FLOATS, real)
        self._biases_out = np.zeros(record.BIAS_FLOATS, real)

    def fill_solution(self) -> None:
        """Bring `floats` and `integers` up to the present state."""
        solution = self._solution
        solution(self.f, self.i, self.floats, self.integers)

    def covariance(self) -> NDArray[Any]:
        """Upper triangle of the covariance of [δr, δv, φ], 45 values."""
        self._state_kernels.covariance(self.f, self._covariance_out)
        return self._covariance_out

    def innovation(self) -> tuple[int, int, NDArray[Any]]:
        """(validity on the board clock in ns, mask of used components, 6 innovations and 6 sigmas)."""
        self._state_kernels.innovation(self.f, self._innovation_out)
        i = self.i
        return int(i[layout.INNOVATION_TIME]), int(i[layout.INNOVATION_MASK]), self._innovation_out

    def biases(self) -> NDArray[Any]:
        """b_g, b_a, mounting yaw and pitch, latency, and their sigmas: 18 values."""
        self._state_kernels.biases(self.f, self._biases_out)
        return self._biases_out

    @property
    def state_ns(self) -> int:
        """Time of the state on the board clock."""
        return int(self.i[layout.TIME])

    @property
    def is_navigating(self) -> bool:
        """Whether there is a navigation solution."""
        return int(self.i[layout.MODE]) == NAVIGATING

    def spoil(self) -> None:
        """Leave NaN in the velocity, as a defective kernel would."""
        self.f[layout.VELOCITY] = np.nan

    def memory(self) -> bytes:
        """The state as it lies in memory."""
        return self.f.tobytes() + self.i.tobytes()
