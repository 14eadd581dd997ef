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
from hal.live.rate_search import RateSearch, beginning_with
from hal.live.serial_link import SerialLink
from host.monitor.view import MonitorView
from host.record.errors import UserError

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
        rates = beginning_with() if baud is None else (baud,)
        is_known = baud is not None or not self._has_rate
        self._search = RateSearch(rates, PATIENCE_S, DOUBTFUL_BYTES, settled=is_known)
        self._began = time.monotonic()
        try:
            self._link = SerialLink(url, self._search.baud, self._receive)
        except PortError as error:
            raise UserError(str(error)) from None
        self._understood = 0
        self._heard_at = 0.0

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
            self._search.hear(len(data))
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
            self._search.understand(now)
        elif not self._search.settled and self._search.in_doubt(now):
            self._link.set_baud(self._search.turn(now))
            view.forget(now)
            self._understood = 0

    def _tell(self, view: MonitorView) -> None:
        counters, now = self._link.counters, self.now_s
        told, style = f"{self._link.baud} baud" if self._has_rate else "open", "green"
        if not self._link.is_open:
            told, style = f"port is gone ({counters.last_problem}), waiting for it", "bold red"
        elif now - self._heard_at > SILENCE_S:
            told, style = f"silent for {now - self._heard_at:.0f} s", "yellow"
        elif self._search.in_doubt(now) or (not self._search.settled and self._search.turns):
            told, style = self._nothing_understood(), "bold red"
        if counters.losses:
            told += f", came back {counters.reopenings} of {counters.losses} times"
        if self.dropped:
            told += f", {self.dropped} bytes not looked at"
        view.source, view.source_style = told, style

    def _nothing_understood(self) -> str:
        if not self._has_rate:
            return "nothing understood: neither our link nor a receiver speaks there"
        hint = "is --baud right? e.g. 9600 or 115200" if self._search.settled else "looking for the rate"
        return f"nothing understood at {self._link.baud} baud, {hint}"
