"""A serial inertial unit on a bench: a motion that the test tells, a wire, and who keeps what it hears."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import crcmod.predefined
import numpy as np

from boards.chips.serial_imu import SerialImu
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import VirtualTime

MS = 1_000_000
crc_ccitt_false = crcmod.predefined.mkCrcFun("crc-ccitt-false")
"""A second opinion."""


class Told(NamedTuple):
    """One frame, decoded from the table of the page on this unit."""

    counter: int
    angle: tuple[int, int, int]
    velocity: tuple[int, int, int]
    status: int
    end_ns: int


class Motion:
    """A world of formulas: each takes times in s and gives a column (m/s², rad/s)."""

    def __init__(self, **columns: Callable[[Any], Any]) -> None:
        self.columns = columns
        self.bandwidths: set[float] = set()

    def sample(self, times_ns: Any, bandwidth_hz: float) -> Any:
        """The world face."""
        assert np.all(np.diff(times_ns) > 0)
        self.bandwidths.add(bandwidth_hz)
        values = np.zeros((len(times_ns), 7))
        values[:, 6] = 25.0
        for k, name in enumerate(("fx", "fy", "fz", "wx", "wy", "wz")):
            if name in self.columns:
                values[:, k] = self.columns[name](np.asarray(times_ns) * 1e-9)
        return values


def decode(data: bytes, end_ns: int) -> Told:
    """A frame by the published layout; AssertionError when it is none."""
    assert len(data) == 32
    assert data[:2] == b"\xaa\x55"
    assert struct.unpack("<H", data[30:])[0] == crc_ccitt_false(data[2:30])
    counter, *counts, status = struct.unpack("<H6iH", data[2:30])
    return Told(counter, tuple(counts[:3]), tuple(counts[3:]), status, end_ns)


class Rig:
    """Chip, wire, and every chunk that came over it."""

    def __init__(self, world: Any = None, baud: int = 230_400, **parameters: Any) -> None:
        self.time = VirtualTime()
        self.world = world or Motion()
        self.wire = UartWire(self.time, baud, "imu")
        self.chunks: list[tuple[bytes, int]] = []
        self.wire.connect(self)
        self.chip = SerialImu(self.time, self.world, self.wire, baud=baud, **parameters)

    def receive(self, data: bytes, time_ns: int) -> None:
        """The far end of the wire."""
        self.chunks.append((data, time_ns))

    def wait(self, duration_ns: int) -> None:
        """Let time pass."""
        end = self.time.now + duration_ns
        self.time.at(end, lambda: None)
        while self.time.now < end:
            self.time.run_next()

    def frames(self) -> list[Told]:
        """All that came, each chunk a frame."""
        return [decode(data, end_ns) for data, end_ns in self.chunks]
