"""An interface of python-can: frames out and in, without the run waiting for a driver.

Drivers may block (slcan writes to a serial port). Each interface therefore has two threads of its own, one
that sends and one that receives; the run only puts frames into a queue and takes frames out of one.
"""

from __future__ import annotations

import contextlib
import logging
import queue
import threading
import time
import uuid
from collections import deque
from collections.abc import Sequence
from typing import Any

from boards.hints import did_you_mean
from hal.can import CanFrame
from host.record.errors import UserError
from host.serve.endpoint import Terms
from host.serve.places import CanPlace

QUEUE_FRAMES = 2048
RECEIVE_S = 0.1
ERRORS_IN_A_ROW = 20
"""Single ones are what somebody else sent; so many without a frame between them: the interface is gone."""
MULTICAST = "udp_multicast"
EXAMPLE = f"{MULTICAST}:239.74.163.2"


class CanAdapter:
    """One interface. `where` tells which."""

    def __init__(self, place: CanPlace, bitrate: int, terms: Terms) -> None:
        """Raises UserError when the interface cannot be had."""
        self.where = f"{place.interface}:{place.channel}"
        self.delivered = 0
        """Frames handed to the driver."""
        self.lost = 0
        """Frames that the driver did not take in time or refused."""
        self.foreign = 0
        """What came and is no classic data frame, or no frame at all."""
        self.overrun = 0
        """Frames that came faster than the run took them."""
        self._terms = terms
        self._mark = f"navtwin-{uuid.uuid4().hex}" if place.interface == MULTICAST else None
        """Multicast brings everybody's frames back to their sender: they are known by this."""
        self._message, self._errors, self._bus = _opened(place, bitrate)
        self._out: queue.Queue[CanFrame | None] = queue.Queue(QUEUE_FRAMES)
        self._in: deque[CanFrame] = deque()
        self._ended = threading.Event()
        self._failed = ""
        self._progress_s = time.monotonic()
        self._threads = [
            threading.Thread(target=work, name=f"{self.where} {work.__name__}", daemon=True)
            for work in (self._send_all, self._receive_all)
        ]
        for thread in self._threads:
            thread.start()

    def send(self, frames: Sequence[CanFrame]) -> None:
        """Frames of the board."""
        for frame in frames:
            try:
                self._out.put_nowait(frame)
            except queue.Full:
                self.lost += 1

    def take(self) -> list[CanFrame]:
        """Frames from outside since the last time."""
        if self._failed:
            self._terms.tell(self._failed)
            self._failed = ""
        found = []
        while self._in:
            found.append(self._in.popleft())
        return found

    @property
    def holds_up(self) -> bool:
        """Whether a run that may wait should: the driver has much to send yet and still takes some."""
        if self._out.qsize() < QUEUE_FRAMES // 2:
            self._progress_s = time.monotonic()
            return False
        return time.monotonic() - self._progress_s < self._terms.stall_s

    def finish(self) -> None:
        """Send what is left; nothing goes out any more. Harmless the second time."""
        if self._threads[0].is_alive():
            with contextlib.suppress(queue.Full):
                self._out.put(None, timeout=1.0)
            self._threads[0].join(2.0)

    def close(self) -> None:
        """Send what is left, and let the interface go."""
        self.finish()
        self._ended.set()
        self._threads[1].join(2.0)
        with contextlib.suppress(*self._errors):
            self._bus.shutdown()

    def _send_all(self) -> None:
        told = False
        while (frame := self._out.get()) is not None:
            message = self._message(
                arbitration_id=frame.identifier,
                data=frame.data,
                is_extended_id=frame.extended,
                channel=self._mark,
            )
            try:
                self._bus.send(message)
                self.delivered += 1
                told = False
            except self._errors as error:
                self.lost += 1
                if not told:
                    self._failed = f"CAN {self.where}: frames are lost: {error}"
                told = True

    def _receive_all(self) -> None:
        errors = 0
        while not self._ended.is_set():
            try:
                message = self._bus.recv(RECEIVE_S)
                errors = 0
            except self._errors as error:
                errors += 1
                self.foreign += 1
                if errors == ERRORS_IN_A_ROW:
                    self._failed = f"CAN {self.where}: nothing can be received: {error}"
                if errors >= ERRORS_IN_A_ROW:
                    self._ended.wait(RECEIVE_S)
                continue
            if message is None or (self._mark is not None and message.channel == self._mark):
                continue
            classic = not (message.is_fd or message.is_remote_frame or message.is_error_frame)
            if not classic or not isinstance(message.arbitration_id, int):  # multicast carries anything
                self.foreign += 1
            elif len(self._in) >= QUEUE_FRAMES:
                self.overrun += 1
            else:
                frame = CanFrame(message.arbitration_id, bytes(message.data), bool(message.is_extended_id))
                self._in.append(frame)


def _opened(place: CanPlace, bitrate: int) -> tuple[Any, tuple[type[Exception], ...], Any]:
    """Message class, errors to expect, and the bus."""
    import can

    errors = (can.CanError, OSError, ValueError, NotImplementedError)
    if place.interface not in can.VALID_INTERFACES:
        hint = did_you_mean(place.interface, sorted(can.VALID_INTERFACES))
        raise UserError(f"{place.option}: python-can has no interface {place.interface!r}; {hint}")
    options: dict[str, Any] = {"bitrate": bitrate}
    if place.interface == MULTICAST:
        options["fd"] = False
    logging.getLogger("can").setLevel(logging.CRITICAL)  # what matters is told below
    try:
        bus = can.Bus(interface=place.interface, channel=place.channel, **options)
    except (*errors, ImportError, TypeError, AttributeError) as error:
        reason = str(error) or type(error).__name__
        raise UserError(
            f"{place.option}: the interface cannot be opened: {reason}; without any hardware there is"
            f" for example --can {place.bus}={EXAMPLE}"
        ) from None
    return can.Message, errors, bus
