"""Whether an I²C master keeps to a slave's highest clock, as far as the slave can tell.

A slave is called at the end of the bytes written to it and at the end of its address before a read. What
comes sooner after the last call than the clocks in between allow was faster; that an idle bus may hide a
fast clock is no matter. Calls at one and the same instant have no bus between them.
"""

from __future__ import annotations

_BYTE_CLOCKS = 9
_SECOND = 1_000_000_000


class I2cSpeed:
    """Counts the clocks that the bus needs at least between two calls."""

    __slots__ = ("_clock_ns", "_heard_ns", "_owed")

    def __init__(self, fastest_hz: int) -> None:
        self._clock_ns = _SECOND // fastest_hz
        self._heard_ns = 0
        self._owed = 0
        """From the last call to the end of the next address byte."""

    def write(self, length: int, time_ns: int) -> bool:
        """`length` bytes have been written by now; False when that was too fast."""
        return self._fits(time_ns, _BYTE_CLOCKS * length, 1 + _BYTE_CLOCKS)

    def read(self, length: int, time_ns: int) -> bool:
        """A read of `length` bytes begins; False when that was too fast."""
        return self._fits(time_ns, 0, 1 + _BYTE_CLOCKS * (1 + length))

    def _fits(self, time_ns: int, clocks: int, owed: int) -> bool:
        passed = time_ns - self._heard_ns
        fits = not 0 < passed < (self._owed + clocks) * self._clock_ns - 1
        self._heard_ns, self._owed = time_ns, owed
        return fits
