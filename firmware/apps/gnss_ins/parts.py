"""What the output asks of the parts that a program is made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.satellite_lists import SatelliteInView


class Navigation(Protocol):
    """Who computes the solution."""

    floats: NDArray[Any]
    integers: NDArray[np.int64]
    """The solution record that `fill_solution` brings up to date."""

    def fill_solution(self) -> None:
        """Bring `floats` and `integers` up to the present state."""
        ...

    def covariance(self) -> NDArray[Any]:
        """Upper triangle of the covariance of [δr, δv, φ], 45 values."""
        ...

    def innovation(self) -> tuple[int, int, NDArray[Any]]:
        """(validity on the board clock in ns, mask of used components, 6 innovations and 6 sigmas)."""
        ...

    def biases(self) -> NDArray[Any]:
        """Slow states and their sigmas: 18 values."""
        ...

    @property
    def state_ns(self) -> int:
        """Time of the state on the board clock."""
        ...

    @property
    def samples_missed(self) -> int:
        """Samples that never came."""
        ...

    @property
    def samples_repeated(self) -> int:
        """Samples that were read twice."""
        ...


class Receiver(Protocol):
    """Who knows what the receiver says."""

    @property
    def latest(self) -> list[int]:
        """The epoch that the filter took last."""
        ...

    @property
    def port_errors(self) -> int:
        """Framing errors and overruns of the port since it runs."""
        ...

    @property
    def pulse_dated(self) -> bool:
        """Whether the time pulse dated the last epoch."""
        ...

    @property
    def epochs(self) -> int:
        """Those that have come."""
        ...

    @property
    def phase_name(self) -> str:
        """How far its set-up is, in words."""
        ...

    @property
    def is_running(self) -> bool:
        """Whether it is set up."""
        ...

    def line_errors(self) -> tuple[int, int]:
        """(messages with a wrong check sum, bytes of garbage) so far."""
        ...

    def satellites(self) -> Sequence[SatelliteInView]:
        """Satellites in view as listed last."""
        ...


class Sensor(Protocol):
    """Who brings the samples."""

    @property
    def reads(self) -> int:
        """Samples that came."""
        ...

    @property
    def starts(self) -> int:
        """How often the sensor was brought up."""
        ...


class HostPort(Protocol):
    """The way to the host; a UART is one."""

    def write(self, data: bytes) -> int:
        """Queue bytes and return how many were taken."""
        ...

    def tx_free(self) -> int:
        """Room in bytes."""
        ...
