"""How old a sample is when it is read: the chip's own sample clock, followed over the bus alone.

The chip renews its outputs every 1.2207 ms of a clock of its own, and no pin of it is wired. But the ND bit
of an output that has been read comes back with the next sample: asked again and again, TEMP_OUT tells the
instant to the distance of two words. From such instants a second-order loop learns the phase and the length
of a period on the processor's clock:

    e = (t − t₀) mod P, wrapped into ±P/2        t₀ ← t − e + e/2,   P ← P + e / (4 n)

n: periods since the last instant. As the pause between two looks grows from PAUSES[0] to a second, the length
is always known well enough for the next one. All in integers: ns, the period in 2⁻¹⁶ ns.
"""

from __future__ import annotations

from typing import Final

NOMINAL_PERIOD: Final = (1_000_000_000 << 16) * 5 // 4096
"""1 / 819.2 Hz in 2⁻¹⁶ ns."""
LARGEST_ERROR: Final = NOMINAL_PERIOD // 50
"""2 % of the period: a clock further off is no clock of this chip."""
GROWTH: Final = 4
UNKNOWN: Final = -1


class SamplePhase:
    """Takes instants at which outputs were renewed; tells how old the sample is that stands there."""

    def __init__(self) -> None:
        self.period = NOMINAL_PERIOD
        self.instants = 0
        self._at_ns = 0
        self._span_ns = 0

    def restart(self) -> None:
        """The chip began anew: the phase is another, the clock the same."""
        self.instants = 0
        self._span_ns = 0

    @property
    def next_look_ns(self) -> int:
        """When the next instant is to be looked for at the latest, so that no period is miscounted."""
        return self._at_ns + min(max(self._span_ns * GROWTH, 20_000_000), 1_000_000_000)

    def renewed(self, at_ns: int) -> None:
        """Outputs were renewed at this board time."""
        if self.instants:
            periods, error = self._split(at_ns)
            self._span_ns = at_ns - self._at_ns
            if periods:
                self.period += (error << 16) // (2 * periods)
                low, high = NOMINAL_PERIOD - LARGEST_ERROR, NOMINAL_PERIOD + LARGEST_ERROR
                self.period = min(max(self.period, low), high)
            at_ns -= error // 2
        self._at_ns = at_ns
        self.instants += 1

    def age_ns(self, read_ns: int) -> int:
        """Of the sample that is read at this board time; UNKNOWN before the first instant."""
        if not self.instants:
            return UNKNOWN
        return ((read_ns - self._at_ns << 16) % self.period) >> 16

    def _split(self, at_ns: int) -> tuple[int, int]:
        """(whole periods since the last instant, what is left over or missing in ns)."""
        since = at_ns - self._at_ns << 16
        periods = (since + self.period // 2) // self.period
        return periods, (since - periods * self.period) >> 16
