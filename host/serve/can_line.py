"""One of the board's CAN buses, served through an interface of python-can, both ways.

What comes from outside is put on the emulated bus by a node of its own: it competes with the board's frames
by identifier, takes its time on the wires, and is acknowledged, disturbed and repeated as theirs are.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from hal.can import CanFrame
from hal.emulated.can import CanNode
from hal.emulated.can_bus import EmulatedCanBus
from host.replay.control_tape import OUTSIDE_NODE
from host.serve.can_adapter import CanAdapter

MOST_WAITING = 4096


class OutsideNode(CanNode):
    """The world outside, on the emulated bus: keeps what the board's nodes sent."""

    def __init__(self, bus: EmulatedCanBus) -> None:
        self.heard: list[CanFrame] = []
        super().__init__(bus, OUTSIDE_NODE)

    def deliver(self, frame: CanFrame, end_ns: int) -> None:
        """From the bus."""
        self.heard.append(frame)


class CanLine:
    """A served CAN bus. `log` is told of frames that were put on it: (bus, frames)."""

    def __init__(
        self, bus: EmulatedCanBus, adapter: CanAdapter, log: Callable[[str, Sequence[CanFrame]], None]
    ) -> None:
        self.name = bus.name
        self.adapter = adapter
        self.sent = 0
        """Frames of the board that were offered outside."""
        self.written = 0
        """Frames from outside that were put on the bus."""
        self.dropped = 0
        """Frames from outside that came faster than the bus carries them."""
        self._bus = bus
        self._log = log
        self._node = OutsideNode(bus)
        self._waiting: deque[CanFrame] = deque()

    def bring_in(self) -> None:
        """Queue what came from outside, as far as the node has room."""
        for frame in self.adapter.take():
            if len(self._waiting) < MOST_WAITING:
                self._waiting.append(frame)
            else:
                self.dropped += 1
        if self._waiting:
            frames = tuple(self._waiting)[: self._node.depth]
            taken = frames[: self._node.send(frames)]
            if taken:
                for _ in taken:
                    self._waiting.popleft()
                self.written += len(taken)
                self._log(self.name, taken)

    def hand_out(self) -> None:
        """Give away what the board has sent."""
        self._bus.catch_up()
        heard = self._node.heard
        if heard:
            self.sent += len(heard)
            self.adapter.send(heard)
            self._node.heard = []
