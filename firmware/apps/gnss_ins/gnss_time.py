"""When was a GNSS epoch valid, on the processor's clock.

With TIMEPULSE on a capture pin: its rising edge marks the top of a UTC second, so an epoch at m ms past
the second was valid m ms after the latest edge that lies before its burst. Without it: validity = start of
the burst − latency of the receiver; the nominal latency is taken off here, what it is off by is a state of
the navigation filter.
"""

from __future__ import annotations

from typing import Final

from hal.machine_code import mypyc_attr

SECOND_NS: Final = 1_000_000_000
NOMINAL_LATENCY_NS: Final = 80_000_000
LONGEST_PULSE_AGE_NS: Final = 1_900_000_000
"""An edge older than this belongs to another second: the receiver has stopped pulsing."""


@mypyc_attr(allow_interpreted_subclasses=True)
class GnssTime:
    """Keeps the edges of the time pulse and dates epochs by them."""

    def __init__(self) -> None:
        self.pulses = 0
        self._edge_ns = 0

    def take_pulse(self, count: int, edge_ns: int) -> None:
        """The capture timer saw an edge (its running count, processor clock in ns)."""
        self.pulses = count
        self._edge_ns = edge_ns

    @property
    def edge(self) -> tuple[int, int]:
        """The latest edge: count, processor clock in ns."""
        return self.pulses, self._edge_ns

    def validity(self, time_of_day_ms: int, burst_start_ns: int) -> tuple[int, bool]:
        """(time of validity on the processor's clock in ns, whether the pulse gave it)."""
        if not self.pulses or burst_start_ns - self._edge_ns > LONGEST_PULSE_AGE_NS:
            return burst_start_ns - NOMINAL_LATENCY_NS, False
        age = (burst_start_ns - self._edge_ns - time_of_day_ms % 1000 * 1_000_000) % SECOND_NS
        return burst_start_ns - age, True
