"""Sets of CAN frames that found the bus idle and go through one behind the other, worked out when asked for.

A board that sends its solution ten times a second on a quiet bus is the common case: nobody competes,
nobody waits for a frame's end. Such a set is kept as it was sent; where each frame ends, which takes its
CRC and its stuff bits, is computed for all kept sets at once.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hal.can import CanFrame
from hal.emulated.can_frame import INTERFRAME_BITS, LONGEST_FRAME_BITS, frame_lengths
from hal.emulated.virtual_time import SECOND

if TYPE_CHECKING:
    from hal.emulated.can import CanNode
    from hal.emulated.can_bus import EmulatedCanBus

LONGEST_NS = (LONGEST_FRAME_BITS + INTERFRAME_BITS) * SECOND
MOST_KEPT = 1024


class CanBursts:
    """The kept sets of one bus, in order of time."""

    def __init__(self, bitrate: int) -> None:
        self.over_by = 0
        """When the last set has ended for sure (ns)."""
        self._bitrate = bitrate
        self._kept: list[tuple[int, CanNode, tuple[CanFrame, ...]]] = []

    def __len__(self) -> int:
        return len(self._kept)

    def keep(self, begin: int, node: CanNode, frames: tuple[CanFrame, ...]) -> None:
        """Frames of `node`, the first of which begins at `begin` (ns), not before `over_by`."""
        self._kept.append((begin, node, frames))
        self.over_by = begin + len(frames) * LONGEST_NS // self._bitrate

    def work_out(self) -> WorkedOut:
        """All kept sets, frame by frame; nothing is kept any more."""
        kept, self._kept = self._kept, []
        frames = [frame for _begin, _node, frames in kept for frame in frames]
        counts = [len(frames) for _begin, _node, frames in kept]
        bits = np.array(frame_lengths(frames)) + INTERFRAME_BITS
        after = np.cumsum(bits)
        before_set = np.repeat(after[np.cumsum(counts) - 1] - np.add.reduceat(bits, _firsts(counts)), counts)
        begins = np.repeat([begin for begin, _node, _frames in kept], counts)
        until = after - before_set
        return WorkedOut(
            [node for _begin, node, frames in kept for _frame in frames],
            frames,
            (begins + (until - bits) * SECOND // self._bitrate).tolist(),
            (begins + (until - INTERFRAME_BITS) * SECOND // self._bitrate).tolist(),
            bits.tolist(),
            kept[-1][0],
            int(until[-1]),
        )


def _firsts(counts: list[int]) -> NDArray[np.int64]:
    """Place of the first frame of each set."""
    return np.concatenate(([0], np.cumsum(counts[:-1], dtype=np.int64)))


class WorkedOut(NamedTuple):
    """Frames one by one, with begin and end in ns and bits up to the next start; where the last set began
    (ns) and how many bits it took."""

    nodes: list[CanNode]
    frames: list[CanFrame]
    begins: list[int]
    ends: list[int]
    bits: list[int]
    last_begin: int
    last_bits: int


class LateCanListener:
    """A listener in no hurry: it is not called but asked, so that no event is spent on it."""

    def __init__(self, bus: EmulatedCanBus) -> None:
        self._bus = bus
        self._heard: list[tuple[CanFrame, int]] = []

    def hear(self, frame: CanFrame, end_ns: int) -> None:
        """From the bus: a frame that got through."""
        self._heard.append((frame, end_ns))

    def hear_all(self, frames: Iterable[CanFrame], ends_ns: Iterable[int]) -> None:
        """Several of them."""
        self._heard.extend(zip(frames, ends_ns, strict=True))

    def take(self) -> list[tuple[CanFrame, int]]:
        """(frame, end in ns) of every frame that has ended by now, each given once."""
        self._bus.catch_up()
        heard, self._heard = self._heard, []
        return heard
