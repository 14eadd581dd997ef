"""Sets of CAN frames that found the bus idle and go through one behind the other, worked out when asked for.

A board that sends its solution ten times a second on a quiet bus is the common case: nobody competes,
nobody waits for a frame's end. Such a set is kept as it was sent; where each frame ends, which takes its
CRC and its stuff bits, is computed for all kept sets at once.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hal.can import CanFrame
from hal.emulated.can_frame import INTERFRAME_BITS, LONGEST_FRAME_BITS, check_frame, frame_lengths
from hal.emulated.virtual_time import SECOND

if TYPE_CHECKING:
    from hal.emulated.can import CanNode
    from hal.emulated.can_bus import EmulatedCanBus

LONGEST_NS = (LONGEST_FRAME_BITS + INTERFRAME_BITS) * SECOND
MOST_KEPT = 1024

HeardFrame = tuple[CanFrame, int, str]
"""A frame, when it ended (ns), and the name of the node that sent it."""

Shape = tuple[tuple[int, ...], tuple[bool, ...], tuple[int, ...]]
"""Identifiers, whether they are extended ones, and numbers of bytes."""


class Burst(NamedTuple):
    """A set whose first frame begins at `begin_ns`."""

    begin_ns: int
    node: CanNode
    frames: tuple[CanFrame, ...]


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
        self._bitrate = bitrate
        self._kept: list[Burst] = []
        self._good_shape: Shape = ((), (), ())

    def __len__(self) -> int:
        return len(self._kept)

    def keep(self, begin: int, node: CanNode, frames: tuple[CanFrame, ...]) -> None:
        """Frames of `node`, at least one; the first begins at `begin` (ns), not before `over_by`.

        ValueError for a frame that CAN does not have.
        """
        identifiers, data, extended = zip(*frames, strict=True)
        shape = identifiers, extended, tuple(map(len, data))
        if shape != self._good_shape:
            for frame in frames:
                check_frame(frame)
            self._good_shape = shape
        self._kept.append(Burst(begin, node, frames))
        self.over_by = begin + len(frames) * LONGEST_NS // self._bitrate

    def take(self) -> list[Burst]:
        """All kept sets; nothing is kept any more. All but the last have ended."""
        kept, self._kept = self._kept, []
        return kept

    def work_out(self, bursts: list[Burst]) -> WorkedOut:
        """When every frame of these sets ends, all side by side; at least one."""
        frames = list(chain.from_iterable([burst.frames for burst in bursts]))
        counts = [len(burst.frames) for burst in bursts]
        lengths = frame_lengths(frames)
        bits = np.array(lengths) + INTERFRAME_BITS
        behind = np.cumsum(bits)
        first = np.cumsum(counts) - counts
        before_set = np.repeat(behind[first] - bits[first], counts)
        begins = np.repeat(np.array([burst.begin_ns for burst in bursts]), counts)
        ends = begins + (behind - before_set - INTERFRAME_BITS) * SECOND // self._bitrate
        senders = [burst.node for burst in bursts for _ in burst.frames]
        return WorkedOut(frames, senders, ends.tolist(), lengths)


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
