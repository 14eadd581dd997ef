"""How long after its validity an epoch arrives, and how evenly.

Bytes that come after a silence begin a burst; the epoch that the burst turns out to hold tells its UTC.

    latency = host's UTC at the arrival of the burst's first bytes − UTC of validity

So the latency is as good as the host's clock (NTP: some ms; without it any value, also a negative one). Its
spread needs no clock that is right: it is the jitter of receiver, USB and operating system together. The
slope is how the host's clock runs against GNSS time.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from firmware.link.frames import NO_TIME_OF_DAY
from host.attach.receiver_port import FIRST_RATE
from host.link.messages import Gnss
from host.monitor.listener import Receiver

SILENCE_NS = 40_000_000
DAY_MS = 86_400_000
MOST_KEPT = 100_000
LEAST_FOR_SLOPE = 30
BELIEVED_MS = 5_000.0
"""Beyond, receiver and host do not have the same time: a recording is played, or a clock is wrong."""
METHOD = (
    "host's UTC at the first bytes of a burst minus the epoch's UTC; absolute only as good as the host's"
    " clock, the spread is the link's jitter"
)


class EpochArrivals:
    """Feed what comes, with time.monotonic_ns()."""

    def __init__(self) -> None:
        self.epochs = 0
        self._receiver = Receiver(FIRST_RATE)
        self._utc_offset_ns = time.time_ns() - time.monotonic_ns()
        self._last_ns = 0
        self._burst_ns = 0
        self._latencies: list[tuple[float, float]] = []

    def take(self, came_ns: int, data: bytes) -> None:
        """Bytes that had come by `came_ns`; none: just time that passes."""
        if data and came_ns - self._last_ns > SILENCE_NS:
            self._note(came_ns, b"")
            self._burst_ns = came_ns
        self._note(came_ns, data)
        if data:
            self._last_ns = came_ns

    def _note(self, came_ns: int, data: bytes) -> None:
        for _, message in self._receiver.feed(data, came_ns / 1e9):
            if isinstance(message, Gnss) and message.time_of_day_ms != NO_TIME_OF_DAY and self._burst_ns:
                self.epochs += 1
                arrival_ms = (self._burst_ns + self._utc_offset_ns) / 1e6 % DAY_MS
                late_ms = (arrival_ms - message.time_of_day_ms + DAY_MS / 2) % DAY_MS - DAY_MS / 2
                if len(self._latencies) < MOST_KEPT:
                    self._latencies.append((self._burst_ns / 1e9, late_ms))

    def figures(self) -> dict[str, Any]:
        """For people and `--json`; empty without an epoch that tells its time."""
        if not self._latencies:
            return {"epochs": self.epochs, "method": METHOD}
        table = np.array(self._latencies)
        late = table[:, 1]
        figures: dict[str, Any] = {
            "epochs": self.epochs,
            "jitter_rms_ms": float(late.std()),
            "method": METHOD,
        }
        if abs(np.median(late)) <= BELIEVED_MS:
            figures |= {
                "latency_median_ms": float(np.median(late)),
                "latency_min_ms": float(late.min()),
                "latency_max_ms": float(late.max()),
            }
        if len(late) >= LEAST_FOR_SLOPE:
            slope = np.polyfit(table[:, 0] - table[0, 0], late, 1)[0]
            figures["host_clock_ppm"] = float(slope * 1000.0)
        return figures
