"""A serial port to look at: any that pyserial opens, with a link that comes back after unplugging.

A thread of the link fills a buffer of bounded size; what comes faster than it can be looked at is dropped
from its old end and counted. Without a given rate the usual ones are tried in turn, until something is
understood.
"""

from __future__ import annotations

import time
from collections import deque
from threading import Lock

from hal.live.port import PortError, has_rate
from hal.live.serial_link import SerialLink
from host.monitor.view import MonitorView
from host.record.errors import UserError

RATES = (230_400, 115_200, 9600, 38_400, 460_800, 921_600, 57_600, 19_200, 4800)
"""In the order in which they are tried: the boards' own, then those of receivers."""
BUFFER_BYTES = 1 << 20
PATIENCE_S = 2.5
"""A receiver speaks once a second; so long without a word that is understood, and the rate is doubted."""
DOUBTFUL_BYTES = 300
SILENCE_S = 3.0


class PortSource:
    """Implements `host.monitor.source.Source`."""

    hint = "q quit   r forget the past"

    def __init__(self, url: str, baud: int | None) -> None:
        """Opens the port. Raises UserError that tells why it cannot be had."""
        self.title = url
        self.dropped = 0
        """Bytes that came too fast to be looked at."""
        self._pieces: deque[tuple[float, bytes]] = deque()
        self._waiting = 0
        self._lock = Lock()
        self._has_rate = has_rate(url)
        self._fixed = baud is not None or not self._has_rate
        self._rate = 0
        self._began = time.monotonic()
        try:
            self._link = SerialLink(url, baud or RATES[0], self._receive)
        except PortError as error:
            raise UserError(str(error)) from None
        self._understood = 0
        self._understood_at = self._heard_at = 0.0
        self._bytes_since = 0

    @property
    def now_s(self) -> float:
        """Since the port was opened."""
        return time.monotonic() - self._began

    @property
    def ended(self) -> bool:
        """A port is waited for."""
        return False

    def pump(self, view: MonitorView, budget_s: float, until_s: float = float("inf")) -> None:
        """Look at what has come, in pieces, as long as there is time."""
        deadline = time.monotonic() + budget_s
        view.listener.baud = self._link.baud
        while piece := self._take():
            self._heard_at, data = piece
            self._bytes_since += len(data)
            view.feed(data, self._heard_at)
            if time.monotonic() > deadline:
                break
        view.time_passes(self.now_s)
        self._doubt_rate(view)
        self._tell(view)

    def press(self, key: str, view: MonitorView) -> None:
        """`r` begins anew."""
        if key == "r":
            view.forget(self.now_s)

    def close(self) -> None:
        """Let go of the port."""
        self._link.close()

    def _receive(self, data: bytes) -> None:
        """From the link's thread."""
        with self._lock:
            self._pieces.append((self.now_s, data))
            self._waiting += len(data)
            while self._waiting > BUFFER_BYTES:
                _, lost = self._pieces.popleft()
                self._waiting -= len(lost)
                self.dropped += len(lost)

    def _take(self) -> tuple[float, bytes] | None:
        """When it came, and what."""
        with self._lock:
            if not self._pieces:
                return None
            piece = self._pieces.popleft()
            self._waiting -= len(piece[1])
        return piece

    def _doubt_rate(self, view: MonitorView) -> None:
        now = self.now_s
        understood = view.listener.understood
        if understood != self._understood:
            self._understood = understood
            self._understood_at = now
            self._bytes_since = 0
            self._fixed = True
        elif not self._fixed and self._is_doubtful(now):
            self._rate = (self._rate + 1) % len(RATES)
            self._link.set_baud(RATES[self._rate])
            self._understood_at = now
            self._bytes_since = 0
            view.forget(now)
            self._understood = 0

    def _is_doubtful(self, now: float) -> bool:
        return now - self._understood_at > PATIENCE_S and self._bytes_since > DOUBTFUL_BYTES

    def _tell(self, view: MonitorView) -> None:
        counters, now = self._link.counters, self.now_s
        told, style = f"{self._link.baud} baud" if self._has_rate else "open", "green"
        if not self._link.is_open:
            told, style = f"port is gone ({counters.last_problem}), waiting for it", "bold red"
        elif now - self._heard_at > SILENCE_S:
            told, style = f"silent for {now - self._heard_at:.0f} s", "yellow"
        elif self._is_doubtful(now) or (not self._fixed and self._rate):
            told, style = self._nothing_understood(), "bold red"
        if counters.losses:
            told += f", came back {counters.reopenings} of {counters.losses} times"
        if self.dropped:
            told += f", {self.dropped} bytes not looked at"
        view.source, view.source_style = told, style

    def _nothing_understood(self) -> str:
        if not self._has_rate:
            return "nothing understood: neither our link nor a receiver speaks there"
        hint = "is --baud right? e.g. 9600 or 115200" if self._fixed else "looking for the rate"
        return f"nothing understood at {self._link.baud} baud, {hint}"
