"""What a receiver's antenna goes through, computed for many epochs at once.

A single instant costs nearly as much as thirty, since most of it is the way into compiled code. A receiver
that asks in equal steps therefore gets instants that were computed ahead. All of it is a function of time
only: when the receiver asks for something else after all, nothing has changed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from host.sim.errors.processes import ProcessBank

EPOCHS_AHEAD = 32

Array = NDArray[np.float64]
AntennaTruth = Callable[[NDArray[np.int64]], Array]
"""Virtual times in ns → (n, 6) latitude, longitude (rad), height (m), v_N, v_E, v_D (m/s) of the antenna."""


class AntennaAhead:
    """True states of the antenna beside its slow position errors."""

    def __init__(self, truth: AntennaTruth, slow: ProcessBank) -> None:
        self._truth = truth
        self._slow = slow
        self._known: dict[int, list[float]] = {}
        self._asked_ns = 0
        self._step_ns = 0

    def at(self, time_ns: int) -> list[float]:
        """The six columns of the truth, then the slow errors, at an instant."""
        step_ns, self._asked_ns = time_ns - self._asked_ns, time_ns
        regular, self._step_ns = step_ns == self._step_ns, step_ns
        state = self._known.pop(time_ns, None)
        if state is None:
            self._compute(time_ns + np.arange(EPOCHS_AHEAD if regular and step_ns > 0 else 1) * step_ns)
            state = self._known.pop(time_ns)
        return state

    def forget(self) -> None:
        """The truth to come is another one."""
        self._known = {}

    def _compute(self, times_ns: NDArray[np.int64]) -> None:
        states = np.hstack((self._truth(times_ns), self._slow.values(times_ns)))
        self._known = dict(zip(times_ns.tolist(), states.tolist(), strict=True))
