"""Receiver epochs that come between blocks of inertial samples."""

from __future__ import annotations

from collections.abc import Iterator

from boards.chips.world import GnssEpoch

Epoch = tuple[int, GnssEpoch]
"""Time of validity in ns, and the solution."""


class EpochFeed:
    """Gives them out as the time goes on."""

    def __init__(self, epochs: Iterator[Epoch]) -> None:
        self._epochs = epochs
        self._waiting = next(epochs, None)

    def until(self, end_ns: int) -> list[Epoch]:
        """Those not yet given, up to an instant."""
        due = []
        while self._waiting is not None and self._waiting[0] <= end_ns:
            due.append(self._waiting)
            self._waiting = next(self._epochs, None)
        return due
