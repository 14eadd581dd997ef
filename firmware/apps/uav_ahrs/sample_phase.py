"""How old a sample is when it is read: the chip's own sample clock, followed over the bus alone.

The chip renews its outputs every 1.2207 ms of a clock of its own, and no pin of it is wired. But the ND bit
of an output that has been read comes back with the next sample: asked again and again, TEMP_OUT tells the
instant to the distance of two words. From such instants t the length of a period on the processor's clock is

    P = (t − t₀) / n,    n = round((t − t₀) / P)

with t₀ the first of them, which follows after LONGEST_SPAN. Looks come close together at first: P is known to
30 µs / (t − t₀), so n is certain as long as t − t₀ grows by no more than a factor of two or three between
them. An instant that is off by more than an eighth of a period says that the clock is another: all begins
anew. In integers: ns, the period in 2⁻¹⁶ ns.
"""

from __future__ import annotations

from typing import Final

NOMINAL_PERIOD: Final = (1_000_000_000 << 16) * 5 // 4096
"""1 / 819.2 Hz in 2⁻¹⁶ ns."""
LARGEST_ERROR: Final = NOMINAL_PERIOD // 25
"""4 % of the period: a clock further off is no clock of this chip."""
SETTLED_SPAN_NS: Final = 300_000_000
LONGEST_SPAN_NS: Final = 8_000_000_000
LONGEST_PAUSE_NS: Final = (2_500_000_000, 1_300_000_000)
"""In turn: a clock that is off by whole periods in the one is not in the other."""
UNKNOWN: Final = -1


class SamplePhase:
    """Takes instants at which outputs were renewed; tells how old the sample is that stands there."""

    def __init__(self) -> None:
        self.period = NOMINAL_PERIOD
        self.instants = 0
        self._first_ns = 0
        self._last_ns = 0

    def restart(self) -> None:
        """The chip began anew."""
        self.instants = 0
        self.period = NOMINAL_PERIOD

    @property
    def is_settled(self) -> bool:
        """Whether the period is known well enough to speak of it."""
        return self.instants > 1 and self._last_ns - self._first_ns >= SETTLED_SPAN_NS

    @property
    def error_ppm(self) -> int:
        """By how much the chip's clock is fast."""
        return (NOMINAL_PERIOD - self.period) * 1_000_000 // self.period

    @property
    def next_look_ns(self) -> int:
        """When the next instant is to be looked for, so that no period is miscounted."""
        if not self.instants:
            return 0
        return self._last_ns + min(self._last_ns - self._first_ns, LONGEST_PAUSE_NS[self.instants & 1])

    def renewed(self, at_ns: int) -> None:
        """Outputs were renewed at this board time."""
        if self.instants:
            since = at_ns - self._first_ns << 16
            periods = (since + self.period // 2) // self.period
            error = since - periods * self.period
            if self.is_settled and abs(error) > self.period // 8:
                self.restart()
            elif periods:
                low, high = NOMINAL_PERIOD - LARGEST_ERROR, NOMINAL_PERIOD + LARGEST_ERROR
                self.period = min(max(since // periods, low), high)
                if at_ns - self._first_ns > LONGEST_SPAN_NS:
                    self._first_ns += (periods // 2 * self.period) >> 16
        if not self.instants:
            self._first_ns = at_ns
        self._last_ns = at_ns
        self.instants += 1

    def age_ns(self, read_ns: int) -> int:
        """Of the sample that is read at this board time; UNKNOWN before the first instant."""
        if not self.instants:
            return UNKNOWN
        return ((read_ns - self._last_ns << 16) % self.period) >> 16
