"""Sets of CAN frames that found the bus idle and go through one behind the other, worked out when asked for.

A board that sends its solution ten times a second on a quiet bus is the common case: nobody competes,
nobody waits for a frame's end. Such a set is kept as it was sent; where each frame ends, which takes its
CRC and its stuff bits, is computed for all kept sets at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hal.can import CanFrame
from hal.emulated.can_frame import INTERFRAME_BITS, LONGEST_FRAME_BITS, frame_lengths
from hal.emulated.virtual_time import SECOND

if TYPE_CHECKING:
    from hal.emulated.can import CanNode
    from hal.emulated.can_bus import EmulatedCanBus

LONGEST_NS = (LONGEST_FRAME_BITS + INTERFRAME_BITS) * SECOND
MOST_KEPT = 1024

HeardFrame = tuple[CanFrame, int, str]
"""A frame, when it ended (ns), and the name of the node that sent it."""


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

    def work_out(self) -> list[tuple[int, int, CanNode, CanFrame, int]]:
        """(begin of the set in ns, bits of it before the frame, node, frame, length in bits) of every frame
        that was kept; nothing is kept any more."""
        kept, self._kept = self._kept, []
        lengths = iter(frame_lengths([frame for _begin, _node, frames in kept for frame in frames]))
        found = []
        for begin, node, frames in kept:
            bits = 0
            for frame, length in zip(frames, lengths, strict=False):
                found.append((begin, bits, node, frame, length))
                bits += length + INTERFRAME_BITS
        return found


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
