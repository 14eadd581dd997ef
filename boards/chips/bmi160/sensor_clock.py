"""The 25.6 kHz sensor time clock (fact sheet sections 3 and 7).

Every sample instant hangs on this clock: an ODR of 100 Hz samples whenever bit 8 of the counter toggles,
that is every 256 ticks.
"""

from __future__ import annotations

from boards.chips.oscillator import Oscillator

TICK_RATE_HZ = 25_600
COUNTER_MASK = 0xFF_FFFF
"""The counter has 24 bits and wraps every 655.36 s."""


class SensorClock(Oscillator):
    """One oscillator from its start. `error_ppb` > 0: it runs fast."""

    __slots__ = ()

    def __init__(self, start_ns: int, error_ppb: int = 0) -> None:
        super().__init__(TICK_RATE_HZ, start_ns, error_ppb)
