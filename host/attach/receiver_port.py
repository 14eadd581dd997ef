"""The port of a real receiver: what came and when, what is sent to it, at the rate of the board's UART."""

from __future__ import annotations

import time
from collections import deque

from hal.live.baud_probe import probe_baud
from hal.live.port import PortError, has_rate
from hal.live.serial_link import SerialLink
from host.record.errors import UserError

FIRST_RATE = 9600


class ReceiverPort:
    """Open from the beginning to the end; unplugged meanwhile, it comes back by itself. Raises UserError."""

    def __init__(self, url: str, baud: int | None) -> None:
        self.url = url
        self.arrived: deque[tuple[int, bytes]] = deque()
        """(time.monotonic_ns() when it had come, bytes), filled by the port's own thread."""
        self.notes: deque[str] = deque()
        try:
            rate = self._found_rate(url) if baud is None else baud
            self.link = SerialLink(url, rate, self._arrive)
        except PortError as error:
            raise UserError(f"--port {error}") from None
        self.link.on_change = self._changed

    @property
    def baud(self) -> int | None:
        """Its rate now; None where a rate means nothing."""
        return self.link.baud if has_rate(self.url) else None

    def take(self) -> list[tuple[int, bytes]]:
        """All that came since the last time."""
        arrived = self.arrived
        return [arrived.popleft() for _ in range(len(arrived))]

    def close(self) -> None:
        """Let go of the port."""
        self.link.close()

    def _found_rate(self, url: str) -> int:
        if not has_rate(url):
            return FIRST_RATE
        probe = probe_baud(url)
        if probe.best is None:
            raise UserError(f"--port {probe}; a receiver that waits to be asked needs --baud")
        return probe.best.baud

    def _arrive(self, data: bytes) -> None:
        self.arrived.append((time.monotonic_ns(), data))

    def _changed(self, there: bool) -> None:
        self.notes.append("the port is there again" if there else "the port has vanished; waiting for it")
