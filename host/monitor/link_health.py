"""How well the line works: counts of the decoder, frames and bytes a second, lateness of what comes."""

from __future__ import annotations

import math
from collections import deque

from host.link.decoder import LinkDecoder
from host.monitor.listener import Receiver

WINDOW_S = 5.0
"""Rates are means over this time."""
LOOKS_KEPT = 100
MINUTE_S = 60.0


class LinkHealth:
    """Looks at a decoder now and then."""

    def __init__(self) -> None:
        self.frames = self.sentences = self.bad_crc = self.lost = self.unknown = self.garbage_bytes = 0
        self.bytes = 0
        self.late_ms: float | None = None
        """How much later the latest dated frame came than the promptest one of the last minutes."""
        self.worst_late_ms = 0.0
        self._promptest = math.inf
        """Least difference between arrival and board time in this minute, and in the one before it."""
        self._promptest_before = math.inf
        self._minute_s = -math.inf
        self._looks: deque[tuple[float, int, int]] = deque(maxlen=LOOKS_KEPT)

    def count(self, decoder: LinkDecoder, at_s: float) -> None:
        """The decoder's counts at a time of the source."""
        self.frames = decoder.frames
        self.sentences = decoder.sentences
        self.bad_crc = decoder.bad_crc
        self.lost = decoder.lost
        self.unknown = decoder.unknown
        self.garbage_bytes = decoder.garbage_bytes
        self.note(at_s)

    def count_receiver(self, receiver: Receiver, at_s: float) -> None:
        """The same of a plain receiver."""
        self.sentences = receiver.heard
        self.bad_crc = receiver.bad_checksums
        self.garbage_bytes = receiver.garbage_bytes
        self.note(at_s)

    def note(self, at_s: float) -> None:
        """Counts stand as they are at `at_s`, from which rates follow."""
        looks = self._looks
        if looks and at_s < looks[-1][0]:
            looks.clear()
        if not looks or at_s - looks[-1][0] >= WINDOW_S / (LOOKS_KEPT - 10):
            looks.append((at_s, self.frames + self.sentences, self.bytes))
        while len(looks) > 2 and at_s - looks[1][0] >= WINDOW_S:
            looks.popleft()

    def note_arrival(self, time_us: int, at_s: float) -> None:
        """A frame with board time `time_us` came at `at_s`. Minutes go by so that clocks may drift apart."""
        offset = at_s - time_us * 1e-6
        if at_s - self._minute_s >= MINUTE_S or at_s < self._minute_s:
            self._minute_s = at_s
            self._promptest_before, self._promptest = self._promptest, math.inf
        self._promptest = min(self._promptest, offset)
        self.late_ms = (offset - min(self._promptest, self._promptest_before)) * 1e3
        self.worst_late_ms = max(self.worst_late_ms, self.late_ms)

    def forget_arrivals(self) -> None:
        """The board's clock, or the way to it, is another now."""
        self._promptest = self._promptest_before = math.inf
        self.late_ms = None
        self.worst_late_ms = 0.0

    @property
    def messages_per_s(self) -> float:
        """Frames and sentences a second."""
        return self._rate(1)

    @property
    def bytes_per_s(self) -> float:
        """Bytes a second."""
        return self._rate(2)

    def _rate(self, place: int) -> float:
        if len(self._looks) < 2:
            return 0.0
        first, last = self._looks[0], self._looks[-1]
        span = last[0] - first[0]
        return (last[place] - first[place]) / span if span > 0 else 0.0
