"""Faults on a CAN bus."""

from __future__ import annotations

from hal.emulated.can import EmulatedCanBus
from hal.emulated.faults.fault import Fault


class CanDisturbance(Fault):
    """The bus is disturbed: no frame gets through. `fired`: attempts that failed."""

    def install(self, bus: EmulatedCanBus) -> None:
        """Put the fault on `bus` for its time."""
        begin, end = bus.begin_disturbance, bus.end_disturbance
        self._schedule(bus.time, lambda: begin(self._strike), lambda: end(self._strike))

    def _strike(self) -> None:
        self.fired += 1
