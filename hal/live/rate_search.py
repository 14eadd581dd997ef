"""The search for the bit rate of a serial line whose other end talks by itself.

    rate k ──so many bytes in so long a time, none understood──► rate k+1, … and round again
       └────something is understood──► settled: the rate stays, whatever comes

At a wrong rate bytes without sense come in. Whoever listens tells what came and whether any of it made sense;
a line that is silent says nothing about its rate, so the search waits for it.
"""

from __future__ import annotations

from collections.abc import Sequence

USUAL_RATES = (230_400, 115_200, 9600, 38_400, 460_800, 921_600, 57_600, 19_200, 4800)
"""Those of boards, then those of receivers."""


def beginning_with(*first: int) -> tuple[int, ...]:
    """The usual rates in another order."""
    return (*first, *(rate for rate in USUAL_RATES if rate not in first))


class RateSearch:
    """`rates` in the order in which they are tried; a rate given by a person is `settled` from the beginning.

    A rate is in doubt when nothing was understood for `patience_s` and more than `least_bytes` have come in
    that time. Times are s of any clock that rises.
    """

    def __init__(
        self,
        rates: Sequence[int],
        patience_s: float,
        least_bytes: int,
        settled: bool = False,
        now_s: float = 0.0,
    ) -> None:
        self.settled = settled
        self.turns = 0
        """How often the rate was changed."""
        self.bytes_heard = 0
        """Since the rate was set, or since something was understood."""
        self._rates = tuple(rates)
        self._patience_s = patience_s
        self._least_bytes = least_bytes
        self._since_s = now_s

    @property
    def baud(self) -> int:
        """The rate now."""
        return self._rates[self.turns % len(self._rates)]

    @property
    def all_tried(self) -> bool:
        """Whether every rate has had its time."""
        return self.turns >= len(self._rates)

    def hear(self, count: int) -> None:
        """So many more bytes have come."""
        self.bytes_heard += count

    def understand(self, now_s: float) -> None:
        """Something made sense."""
        self.settled = True
        self._begin(now_s)

    def in_doubt(self, now_s: float) -> bool:
        """Whether the rate seems wrong, also one that was settled."""
        return now_s - self._since_s >= self._patience_s and self.bytes_heard > self._least_bytes

    def turn(self, now_s: float) -> int:
        """Go on to the next rate."""
        self.turns += 1
        self._begin(now_s)
        return self.baud

    def wait_again(self, now_s: float) -> None:
        """Stay at this rate for another while."""
        self._begin(now_s)

    def _begin(self, now_s: float) -> None:
        self._since_s = now_s
        self.bytes_heard = 0
