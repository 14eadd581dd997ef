"""Test equipment: rate and specific force of a sensor with errors of a choice, told over SPI.

No chip: a source beside the board's own sensors, for errors that these cannot have. A rising edge at LATCH
holds the values of that instant; a transaction that begins with 0x52 reads them behind that byte: rate x, y,
z (rad/s), specific force x, y, z (m/s²), float32, low byte first. Before the first edge, and to other
requests, the answer is zero.
"""

from __future__ import annotations

from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from boards.chips.latch_pin import LatchPin
from boards.chips.world import ImuWorld
from hal.emulated.pins import Net
from hal.emulated.spi import SpiChip
from hal.emulated.virtual_time import VirtualTime

READ: Final = 0x52
ANSWER: Final = 25
"""A zero and six numbers."""
BANDWIDTH_HZ: Final = 100.0
USUAL_PERIOD_NS: Final = 5_000_000
AHEAD: Final = 200
"""Samples that are asked of the world at once, at the instants where edges are expected."""
NEAR_NS: Final = 20_000
"""An edge within this of an expected instant takes the sample made for it."""


class EquivalentFeed(SpiChip):
    """One source."""

    feels: ClassVar[str] = "imu"
    """The world that it asks."""
    measures: ClassVar[tuple[str, ...]] = ("gyro", "accel")
    """Of what the world tells."""

    def __init__(self, time: VirtualTime, world: ImuWorld) -> None:
        self.pins: dict[str, Net | None] = LatchPin(self.latch)
        self._time = time
        self._world = world
        self._latched_ns = -1
        self._before_ns = -1
        self._times: list[int] = []
        self._rows: list[bytes] = []
        self._row = -1
        self._powered = True

    def latch(self) -> None:
        """A rising edge, now."""
        self._before_ns, self._latched_ns = self._latched_ns, self._time.now

    def look_anew(self) -> None:
        """What was asked of the world ahead is forgotten: its defects have changed."""
        self._rows = []

    def power(self, on: bool) -> None:
        """Switch it on or off, now."""
        self._powered = on

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period; see `hal.emulated.spi.SpiSlave`."""
        length = len(mosi)
        if not self._powered or self._latched_ns < 0 or mosi[0] != READ:
            return bytes(length)
        told = self._values()
        return told if length == len(told) else told[:length].ljust(length, b"\0")

    def _values(self) -> bytes:
        """A zero and what the edge that came last found."""
        now, rows, row = self._latched_ns, self._rows, self._row + 1
        if row < len(rows) and abs(self._times[row] - now) <= NEAR_NS:
            self._row = row
            return rows[row]
        row -= 1
        if 0 <= row < len(rows) and abs(self._times[row] - now) <= NEAR_NS:
            return rows[row]
        self._ask(now)
        self._row = 0
        return self._rows[0]

    def _ask(self, now: int) -> None:
        period = now - self._before_ns
        if self._before_ns < 0 or abs(period - USUAL_PERIOD_NS) > USUAL_PERIOD_NS // 100:
            period = USUAL_PERIOD_NS
        times: NDArray[np.int64] = now + period * np.arange(AHEAD, dtype=np.int64)
        values = self._world.sample(times, BANDWIDTH_HZ)
        told = np.zeros((len(times), ANSWER), np.uint8)
        told[:, 1:] = np.concatenate((values[:, 3:6], values[:, 0:3]), axis=1).astype("<f4").view(np.uint8)
        self._times = times.tolist()
        image = told.tobytes()
        self._rows = [image[k : k + ANSWER] for k in range(0, len(image), ANSWER)]
