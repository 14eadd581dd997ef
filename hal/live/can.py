"""CAN in real time, on any bus that python-can opens (socketcan, slcan, udp_multicast, virtual …)."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from threading import Thread
from time import monotonic
from typing import Any

import can

from hal.can import CanFrame
from hal.live.can_link import CanLink
from hal.live.cpu import LiveCpu

RECEIVE_FRAMES = 4096
LOOK_S = 0.1
JOIN_S = 2.0

ECHOING = frozenset({"udp_multicast"})
"""Interfaces of python-can that hand a node its own frames although it did not ask for them."""
ECHO_S = 0.5


class CanPortError(Exception):
    """A CAN bus cannot be opened. The message says why."""


class LiveCan:
    """Implements `hal.can.CanController`.

    Only classic data frames are received: `ignored` counts error, remote and FD frames, `overruns` those
    that the firmware did not fetch in time, `failures` frames that the bus refused. A bus that vanishes takes
    no frames until it is there again (`link` counts).
    """

    def __init__(self, cpu: LiveCpu, interface: str, channel: str, **options: Any) -> None:
        self.frames_received = self.ignored = self.overruns = self.failures = 0
        self._cpu = cpu
        self._received: deque[CanFrame] = deque()
        self._echoes: deque[tuple[float, CanFrame]] | None = deque() if interface in ECHOING else None
        """Own frames that will come back, and until when."""
        self._closing = False
        try:
            self.link = CanLink(interface, channel, receive_own_messages=False, **options)
        except Exception as error:  # each interface raises its own
            raise CanPortError(
                f"CAN {interface}:{channel} cannot be opened: {error}; e.g. socketcan:can0, "
                "slcan:/dev/ttyACM0 or virtual:test"
            ) from None
        self._thread = Thread(target=self._read_for_ever, name=f"read {interface}:{channel}", daemon=True)
        self._thread.start()

    def send(self, frames: Sequence[CanFrame]) -> int:
        """Queue frames in order and return how many were taken."""
        self._cpu.safe_point()
        for count, frame in enumerate(frames):
            message = can.Message(
                arbitration_id=frame.identifier,
                data=frame.data,
                is_extended_id=frame.extended,
                is_rx=False,
            )
            if self._echoes is not None:
                self._echoes.append((monotonic() + ECHO_S, frame))
            if not self.link.send(message):
                self.failures += 1
                if self._echoes:
                    self._echoes.pop()
                return count
        return len(frames)

    @property
    def last_problem(self) -> str:
        """What the bus complained about last."""
        return self.link.last_problem

    def receive(self) -> CanFrame | None:
        """The oldest frame received, or None."""
        self._cpu.safe_point()
        return self._received.popleft() if self._received else None

    def close(self) -> None:
        """Leave the bus."""
        self._closing = True
        self._thread.join(JOIN_S)
        self.link.close()

    def _read_for_ever(self) -> None:
        while not self._closing:
            message = self.link.recv(LOOK_S)
            if message is not None:
                self._take(message)

    def _take(self, message: can.Message) -> None:
        if message.is_error_frame or message.is_remote_frame or message.is_fd:
            self.ignored += 1
            return
        frame = CanFrame(message.arbitration_id, bytes(message.data), message.is_extended_id)
        if self._is_echo(frame):
            return
        if len(self._received) < RECEIVE_FRAMES:
            self._received.append(frame)
            self.frames_received += 1
        else:
            self.overruns += 1

    def _is_echo(self, frame: CanFrame) -> bool:
        """Own frames come back in order; one that was lost on the way is forgotten after a while."""
        echoes = self._echoes
        while echoes:
            ends, own = echoes[0]
            if own != frame and ends > monotonic():
                return False
            echoes.popleft()
            if own == frame:
                return True
        return False
