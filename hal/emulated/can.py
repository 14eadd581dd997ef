"""CAN nodes: the controller of an emulated processor, and nodes without one for the world outside."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from hal.can import CanFrame
from hal.emulated.can_bus import ERROR_PASSIVE, EmulatedCanBus
from hal.emulated.can_frame import frame_bits
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import EmulatedLine

__all__ = ["CanNode", "EmulatedCanBus", "EmulatedCanController"]


class CanNode:
    """A node without a processor: what a test or the world outside puts on the bus."""

    def __init__(self, bus: EmulatedCanBus, name: str = "node", depth: int = 64) -> None:
        self.bus = bus
        self.name = name
        self.depth = depth
        self.error_count = 0
        """Transmit error counter."""
        self.attempts_failed = 0
        self.off_until: int | None = None
        """While bus-off: when it comes back (FAR: not before the disturbance ends)."""
        self.queue: deque[tuple[CanFrame, int]] = deque()
        """Frames that wait, each with its length in bits."""
        self.planned = 0
        self.prompt = False
        """Whether frames must be delivered exactly when they end."""
        bus.attach(self)

    def send(self, frames: Sequence[CanFrame]) -> int:
        """Queue frames in order and return how many were taken. ValueError for one that CAN does not have."""
        bus = self.bus
        count = len(frames)
        if bus.carry(self, frames, count):
            return count
        bus.catch_up()
        room = self.depth - len(self.queue) - self.planned
        taken = frames[:room] if room > 0 else ()
        if taken:
            self.queue.extend([(frame, frame_bits(frame)) for frame in taken])
            bus.replan()
        return len(taken)

    def deliver(self, frame: CanFrame, end_ns: int) -> None:
        """A frame of another node ended well at `end_ns`."""

    @property
    def state(self) -> str:
        """ "error-active", "error-passive" or "bus-off"."""
        self.bus.catch_up()
        if self.off_until is not None:
            return "bus-off"
        return "error-passive" if self.error_count >= ERROR_PASSIVE else "error-active"


class EmulatedCanController(CanNode):
    """The controller of a processor. Implements `hal.can.CanController`.

    `receive_depth` frames wait for the firmware; when they are full a further one is lost (`overruns`).
    """

    def __init__(
        self,
        cpu: EmulatedCpu,
        bus: EmulatedCanBus,
        name: str = "can",
        depth: int = 16,
        receive_depth: int = 32,
    ) -> None:
        super().__init__(bus, name, depth)
        self.overruns = 0
        self._cpu = cpu
        self._receive_depth = receive_depth
        self._received: deque[CanFrame] = deque()
        self._line: EmulatedLine | None = None
        cpu.reset_hooks.append(self._reset)

    def pend_on_receive(self, line: EmulatedLine) -> None:
        """Wire the receive interrupt: request `line` at the end of every frame received."""
        self._line = line
        self.prompt = True
        self.bus.catch_up()
        self.bus.replan()

    def receive(self) -> CanFrame | None:
        """The oldest frame received, or None."""
        self._cpu.poll()
        self.bus.catch_up()
        return self._received.popleft() if self._received else None

    def deliver(self, frame: CanFrame, end_ns: int) -> None:
        """A frame of another node ended well at `end_ns`."""
        if len(self._received) >= self._receive_depth:
            self.overruns += 1
            return
        self._received.append(frame)
        if self._line is not None:
            self._line.request()

    def _reset(self) -> None:
        self.bus.withdraw(self)
        self._received.clear()
        self.error_count = 0
        self.off_until = None
