"""Faults on a net between two pins."""

from __future__ import annotations

from hal.emulated.faults.fault import Fault
from hal.emulated.pins import Net
from hal.emulated.virtual_time import FAR


class PinStuck(Fault):
    """A net stays at `level`, whatever its driver does: a broken data-ready line, for example. `fired`:
    changes of level that nobody saw. A net that another fault holds already is left to it."""

    def __init__(self, start_ns: int, end_ns: int = FAR, level: bool = False) -> None:
        super().__init__(start_ns, end_ns)
        self._stuck = level
        self._driven = level
        self._holds = False

    def install(self, net: Net) -> None:
        """Put the fault on `net` for its time."""

        def begin() -> None:
            if net.holder is None:
                self._holds = True
                self._driven = net.level
                net.set(self._stuck)
                net.holder = self._drive

        def end() -> None:
            if self._holds:
                net.holder = None
                net.set(self._driven)

        self._schedule(net.time, begin, end)

    def _drive(self, level: bool) -> None:
        self.fired += level != self._driven
        self._driven = level
