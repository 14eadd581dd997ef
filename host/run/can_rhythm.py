"""Counts what comes over a CAN bus, identifier by identifier and second by second, as the run goes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hal.can import CanFrame
from hal.emulated.can_bursts import HeardSets
from hal.emulated.virtual_time import SECOND
from host.capture.blocks import EXTENDED
from host.record.can_course import CanCourse

MOST_IDENTIFIERS = 64
"""So many of one bus are kept apart; a board that sends more is not in a rhythm."""
WORTH_COUNTING = 2048
"""So many frames are gathered before they are counted at once."""

Integers = NDArray[np.int64]


class CanRhythm:
    """One bus."""

    def __init__(self, bus: str) -> None:
        self._bus = bus
        self._heads: list[tuple[Integers, Integers]] = []
        """Identifiers and ends of frames that wait to be counted."""
        self._waiting = 0
        self._counted: dict[int, _Counted] = {}

    def add(self, heard: Sequence[tuple[CanFrame, int, *tuple[object, ...]]]) -> None:
        """More frames with their ends in ns and whatever else is known, in the order of the ends."""
        if isinstance(heard, HeardSets):
            self._heads.append((heard.identifiers, heard.ends_ns))
        else:
            heads = [(one[0].identifier | EXTENDED * one[0].extended, one[1]) for one in heard]
            identifiers, ends_ns = np.array(heads, dtype=np.int64).reshape(-1, 2).T
            self._heads.append((identifiers, ends_ns))
        self._waiting += len(heard)
        if self._waiting >= WORTH_COUNTING:
            self._count()

    def courses(self, duration_ns: int) -> list[CanCourse]:
        """All that was counted, after the run."""
        self._count()
        return [
            CanCourse(self._bus, identifier, *counted.until(duration_ns))
            for identifier, counted in sorted(self._counted.items())
        ]

    def _count(self) -> None:
        if not self._heads:
            return
        identifiers, ends_ns = map(np.concatenate, zip(*self._heads, strict=True))
        self._heads.clear()
        self._waiting = 0
        for identifier in np.unique(identifiers).tolist():
            if identifier not in self._counted:
                if len(self._counted) == MOST_IDENTIFIERS:
                    continue
                self._counted[identifier] = _Counted()
            self._counted[identifier].add(ends_ns[identifiers == identifier])


class _Counted:
    """One identifier."""

    def __init__(self) -> None:
        self._frames = np.zeros(0, dtype=np.int64)
        self._gaps = np.zeros(0)
        self._last_ns = 0

    def add(self, ends_ns: Integers) -> None:
        """Frames that ended at these instants."""
        self._reach(int(ends_ns[-1]) // SECOND + 1)
        seconds = ends_ns // SECOND
        np.add.at(self._frames, seconds, 1)
        np.maximum.at(self._gaps, seconds, np.diff(ends_ns, prepend=self._last_ns) / SECOND)
        self._last_ns = int(ends_ns[-1])

    def until(self, duration_ns: int) -> tuple[Integers, NDArray[np.float64]]:
        """Frames and gaps of every second of the run."""
        whole = -(-duration_ns // SECOND)
        self._reach(whole)
        if whole:
            self._gaps[whole - 1] = max(self._gaps[whole - 1], (duration_ns - self._last_ns) / SECOND)
        return self._frames, self._gaps

    def _reach(self, seconds: int) -> None:
        more = seconds - len(self._frames)
        if more > 0:
            self._frames = np.concatenate((self._frames, np.zeros(more, dtype=np.int64)))
            self._gaps = np.concatenate((self._gaps, np.zeros(more)))
