"""Sets of CAN frames that found the bus idle and go through one behind the other, worked out when asked for.

A board that sends its solution ten times a second on a quiet bus is the common case: nobody competes,
nobody waits for a frame's end. Such a set is kept as it was sent; where each frame ends, which takes its
CRC and its stuff bits, is computed for all kept sets at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hal.can import CanFrame, CanSet
from hal.emulated.can_frame import INTERFRAME_BITS, LONGEST_FRAME_BITS, check_frame, frame_lengths
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


class WorkedOut(NamedTuple):
    """The frames of kept sets in their order, with what was found out about each."""

    frames: list[CanFrame]
    senders: list[CanNode]
    ends_ns: list[int]
    lengths: list[int]
    """In bits."""


class CanBursts:
    """The kept sets of one bus, in order of time."""

    def __init__(self, bitrate: int) -> None:
        self.over_by = 0
        """When the last set has ended for sure (ns)."""
        self.kept: list[Burst] = []
        self._longest_ns = LONGEST_BITS * SECOND // bitrate
        self._bitrate = bitrate
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

    def work_out(self, bursts: list[Burst]) -> WorkedOut:
        """When every frame of these sets ends, all side by side; at least one."""
        begin_of_set, nodes, sets = zip(*bursts, strict=True)
        frames = list(chain.from_iterable(sets))
        counts = list(map(len, sets))
        lengths = frame_lengths(frames)
        bits = np.array(lengths) + INTERFRAME_BITS
        behind = np.cumsum(bits)
        first = np.cumsum(counts) - counts
        before_set = np.repeat(behind[first] - bits[first], counts)
        begins = np.repeat(np.array(begin_of_set), counts)
        ends = begins + (behind - before_set - INTERFRAME_BITS) * SECOND // self._bitrate
        senders = [node for node, count in zip(nodes, counts, strict=True) for _ in range(count)]
        return WorkedOut(frames, senders, ends.tolist(), lengths)


def _check(frames: Iterable[CanFrame]) -> None:
    for frame in frames:
        check_frame(frame)


class LateCanListener:
    """A listener in no hurry: it is not called but asked, so that no event is spent on it."""

    def __init__(self, bus: EmulatedCanBus) -> None:
        self._bus = bus
        self._heard: list[HeardFrame] = []

    def hear(self, frame: CanFrame, end_ns: int, sender: str) -> None:
        """From the bus: a frame that got through."""
        self._heard.append((frame, end_ns, sender))

    def hear_all(self, heard: list[HeardFrame]) -> None:
        """Several of them."""
        self._heard += heard

    def take(self) -> list[HeardFrame]:
        """Every frame that has ended by now, each given once."""
        self._bus.catch_up()
        heard, self._heard = self._heard, []
        return heard
