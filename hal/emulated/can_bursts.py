"""Sets of CAN frames that found the bus idle and go through one behind the other, worked out when asked for.

A board that sends its solution ten times a second on a quiet bus is the common case: nobody competes,
nobody waits for a frame's end. Such a set is kept as it was sent; where each frame ends, which takes its
CRC and its stuff bits, is computed for all kept sets at once.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, repeat
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import NDArray

from hal.can import CanFrame, CanSet
from hal.emulated.can_frame import (
    INTERFRAME_BITS,
    LONGEST_FRAME_BITS,
    check_frame,
    ends_of_sets,
)
from hal.emulated.virtual_time import SECOND

if TYPE_CHECKING:
    from hal.emulated.can import CanNode
    from hal.emulated.can_bus import EmulatedCanBus

LONGEST_BITS = LONGEST_FRAME_BITS + INTERFRAME_BITS
MOST_KEPT = 1024

HeardFrame = tuple[CanFrame, int, str]
"""A frame, when it ended (ns), and the name of the node that sent it."""

Burst = tuple[int, "CanNode", Sequence[CanFrame]]
"""When the first frame of a set begins (ns), who sends it, and the set."""


class HeardSets(Sequence[HeardFrame]):
    """Frames of many sets that one node sent, column by column."""

    def __init__(
        self, identifiers: tuple[int, ...], data: bytes, ends_ns: NDArray[np.int64], bits: int, sender: str
    ) -> None:
        self.set_identifiers = identifiers
        """Of every set."""
        self.data = data
        """Eight bytes a frame."""
        self.ends_ns = ends_ns
        self.bits = bits
        """Of all frames, interframe spaces included."""
        self.sender = sender

    @property
    def identifiers(self) -> NDArray[np.int64]:
        """Of every frame; not to be written to."""
        return _repeated(self.set_identifiers, len(self.ends_ns) // len(self.set_identifiers))

    def __len__(self) -> int:
        return len(self.ends_ns)

    def __iter__(self) -> Iterator[HeardFrame]:
        sets = len(self.ends_ns) // len(self.set_identifiers)
        frames = CanSet(self.set_identifiers * sets, self.data)
        return zip(frames, self.ends_ns.tolist(), repeat(self.sender))

    @overload
    def __getitem__(self, index: int) -> HeardFrame: ...
    @overload
    def __getitem__(self, index: slice) -> list[HeardFrame]: ...
    def __getitem__(self, index: int | slice) -> HeardFrame | list[HeardFrame]:
        return list(self)[index]


@functools.lru_cache(16)
def _repeated(identifiers: tuple[int, ...], times: int) -> NDArray[np.int64]:
    repeated = np.tile(np.array(identifiers, np.int64), times)
    repeated.flags.writeable = False
    return repeated


class CanBursts:
    """The kept sets of one bus, in order of time."""

    def __init__(self, bitrate: int) -> None:
        self.over_by = 0
        """When the last set has ended for sure (ns)."""
        self.kept: list[Burst] = []
        self._longest_ns = LONGEST_BITS * SECOND // bitrate
        self._good_identifiers: tuple[int, ...] = ()

    def keep(self, begin: int, node: CanNode, frames: Sequence[CanFrame], count: int) -> None:
        """`count` frames of `node`, the first of which begins at `begin` (ns), not before `over_by`.

        ValueError for a frame that CAN does not have; identifiers of a `CanSet` are looked at once.
        """
        if type(frames) is not CanSet:
            _check(frames)
        elif frames.identifiers is not self._good_identifiers:
            _check(frames)
            self._good_identifiers = frames.identifiers
        self.kept.append((begin, node, frames))
        self.over_by = begin + count * self._longest_ns

    def take(self) -> list[Burst]:
        """All kept sets; nothing is kept any more. All but the last have ended."""
        kept, self.kept = self.kept, []
        return kept


def heard_sets(bursts: list[Burst], bitrate: int) -> HeardSets | None:
    """Sets of one node with one tuple of identifiers, all that have ended; None for others."""
    begins, nodes, sets = zip(*bursts, strict=True)
    first = sets[0]
    same = all(type(one) is CanSet and one.identifiers is first.identifiers for one in sets)
    if not same or nodes.count(nodes[0]) < len(nodes):
        return None
    data = b"".join([one.data for one in sets])
    ends_ns, bits = ends_of_sets(np.array(begins, np.int64), first.identifiers, data, bitrate)
    return HeardSets(first.identifiers, data, ends_ns, bits, nodes[0].name)


def _check(frames: Iterable[CanFrame]) -> None:
    for frame in frames:
        check_frame(frame)


class LateCanListener:
    """A listener in no hurry: it is not called but asked, so that no event is spent on it."""

    def __init__(self, bus: EmulatedCanBus) -> None:
        self._bus = bus
        self._heard: list[HeardFrame] = []
        self._parts: list[Sequence[HeardFrame]] = [self._heard]

    def hear(self, frame: CanFrame, end_ns: int, sender: str) -> None:
        """From the bus: a frame that got through."""
        self._heard.append((frame, end_ns, sender))

    def hear_all(self, heard: Sequence[HeardFrame]) -> None:
        """Several of them."""
        self._heard = []
        self._parts += [heard, self._heard]

    def take_parts(self) -> list[Sequence[HeardFrame]]:
        """Every frame that has ended by now, each given once; many of one kind may come as `HeardSets`."""
        self._bus.catch_up()
        parts = [part for part in self._parts if part]
        self._heard = []
        self._parts = [self._heard]
        return parts

    def take(self) -> list[HeardFrame]:
        """The same frame by frame."""
        return list(chain.from_iterable(self.take_parts()))
