"""A GR-87 on a bench: a world that stands still but for its clock, a wire, and who keeps what it hears."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import reduce
from operator import xor
from typing import Any

from boards.chips.gr87 import Gr87
from boards.chips.world import GnssEpoch, Satellite
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import SECOND, VirtualTime

LEAP = 18
START_GPS_NS = (2305 * 604_800 + 5 * 86_400 + 9 * 3600 + 27 * 60 + 25 + LEAP) * SECOND
"""2024-03-15 09:27:25 UTC."""
SKY = (
    *(
        Satellite("GPS", number, math.radians(elevation), math.radians(azimuth), cn0, used)
        for number, elevation, azimuth, cn0, used in (
            (1, 53, 280, 36.2, True), (3, 29, 301, 24.0, True), (4, 55, 223, 36.6, True),
            (8, 38, 166, 16.0, False), (11, 40, 245, 29.0, True), (12, 5, 34, 0.0, False),
        )
    ),
    Satellite("GLONASS", 67, 1.0, 2.0, 40.0, True),
)  # fmt: skip
EPOCH = GnssEpoch(
    fix=True, time_known=True, gps_time_ns=START_GPS_NS, leap_seconds=LEAP,
    latitude=math.radians(50.0 + 30.12345 / 60.0), longitude=math.radians(-(4.0 + 15.54321 / 60.0)),
    height=87.44 + 48.1, geoid_separation=48.1, velocity_ned=(3.0, 4.0, -0.25), h_acc=1.2, v_acc=2.0,
    s_acc=0.1, pdop=1.56, hdop=0.95, vdop=1.27, tdop=0.9, satellites=SKY, latency_ns=100_000_000,
)  # fmt: skip


class Rig:
    """Receiver, wire and what came over it; its world is `epoch` with the time moved on."""

    def __init__(self, **parameters: Any) -> None:
        self.time = VirtualTime()
        self.world_epoch = EPOCH
        self.wire = UartWire(self.time, 4800, "gnss")
        self.heard: list[tuple[bytes, int]] = []
        self.wire.connect(self)
        self.chip = Gr87(self.time, self, self.wire, **{"start_state": "hot", **parameters})

    def epoch(self, time_ns: int) -> GnssEpoch:
        return replace(self.world_epoch, gps_time_ns=self.world_epoch.gps_time_ns + time_ns)

    def receive(self, data: bytes, time_ns: int) -> None:
        self.heard.append((data, time_ns))

    def wait(self, seconds: float) -> bytes:
        """What comes in that time."""
        self.heard.clear()
        end = self.time.now + round(seconds * SECOND)
        self.time.at(end, lambda: None)
        while self.time.now < end:
            self.time.run_next()
        return b"".join(data for data, _ in self.heard)

    def say(self, body: str) -> None:
        self.chip.receive(sentence(body), self.time.now)


def sentence(body: str) -> bytes:
    return f"${body}*{reduce(xor, body.encode(), 0):02X}\r\n".encode()


def lines(data: bytes) -> list[str]:
    return [line for line in data.decode().split("\r\n") if line]


def body(line: str) -> str:
    text, check = line[1:].rsplit("*", 1)
    assert int(check, 16) == reduce(xor, text.encode(), 0)
    return text
