"""A BMI160 on a bench: a world given by a function, SPI by hand, time by hand."""

from __future__ import annotations

from collections.abc import Callable
from struct import unpack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.chips.bmi160 import Bmi160
from hal.emulated.pins import Net
from hal.emulated.virtual_time import VirtualTime

MS = 1_000_000
G = 9.80665
BYTE_NS = 1_600
"""One byte at 5 MHz."""

Motion = Callable[[NDArray[np.float64]], dict[str, Any]]


def at_rest(_t: NDArray[np.float64]) -> dict[str, Any]:
    """Flat on a table at 25 °C."""
    return {"fz": G, "temperature": 25.0}


class BenchWorld:
    """The ImuWorld of a function of time in seconds; holds every caller to the contract."""

    def __init__(self, motion: Motion = at_rest) -> None:
        self.motion = motion
        self.calls: list[tuple[int, int, int, float]] = []
        """(first ns, last ns, samples, bandwidth) of every call."""
        self._last = -1

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> NDArray[np.float64]:
        """See boards.chips.world.ImuWorld."""
        assert times_ns.dtype == np.int64
        assert len(times_ns) > 0
        assert bandwidth_hz > 0.0
        assert (np.diff(times_ns) > 0).all()
        assert times_ns[0] > self._last - 8_000_000_000
        self._last = int(times_ns[-1])
        self.calls.append((int(times_ns[0]), int(times_ns[-1]), len(times_ns), bandwidth_hz))
        values = np.zeros((len(times_ns), 7))
        names = ("fx", "fy", "fz", "wx", "wy", "wz", "temperature")
        for name, value in self.motion(times_ns * 1e-9).items():
            values[:, names.index(name)] = value
        return values


class Rig:
    """Chip, world, nets and a hand on the clock."""

    def __init__(self, motion: Motion = at_rest, *, listen: str = "", **options: Any) -> None:
        self.time = VirtualTime()
        self.world = BenchWorld(motion)
        self.chip = Bmi160(self.time, self.world, **options)
        self.nets = {name: Net(self.time, name) for name in ("INT1", "INT2")}
        self.edges: dict[str, list[tuple[int, bool]]] = {"INT1": [], "INT2": []}
        for name, net in self.nets.items():
            self.chip.pins[name] = net
            if name in listen:
                net.listen(lambda level, when, name=name: self.edges[name].append((when, level)))  # type: ignore[misc]

    # -- time --------------------------------------------------------------------------------------

    def wait(self, duration_ns: int) -> None:
        """Let time pass; events run."""
        self.until(self.time.now + duration_ns)

    def until(self, end_ns: int) -> None:
        """Let time pass to an instant."""
        while self.time.next_due <= end_ns:
            self.time.run_next()
        self.time.now = end_ns

    # -- SPI ---------------------------------------------------------------------------------------

    def spi(self, mosi: bytes) -> bytes:
        """One transaction on the wire."""
        start = self.time.now
        end = start + len(mosi) * BYTE_NS
        miso = self.chip.transaction(mosi, start, end)
        assert len(miso) == len(mosi)
        self.until(end)
        return miso

    def read(self, register: int, count: int = 1) -> bytes:
        """Burst read."""
        return self.spi(bytes((0x80 | register,)) + bytes(count))[1:]

    def write(self, register: int, *values: int, gap_ns: int = 450_000) -> None:
        """Burst write and the pause that suspend mode wants."""
        self.spi(bytes((register, *values)))
        self.wait(gap_ns)

    def start(self, *, accel: bool = True, gyro: bool = True) -> None:
        """Past power-up, on SPI, sensors in normal mode."""
        self.until(max(self.time.now, 10 * MS))
        self.read(0x7F)
        if accel:
            self.write(0x7E, 0x11, gap_ns=4 * MS)
        if gyro:
            self.write(0x7E, 0x15, gap_ns=80 * MS)

    # -- data --------------------------------------------------------------------------------------

    def sample(self) -> tuple[int, ...]:
        """Gyroscope and accelerometer counts."""
        return unpack("<6h", self.read(0x0C, 12))

    def sensor_time(self) -> int:
        """The 24-bit counter."""
        return int.from_bytes(self.read(0x18, 3), "little")


def rising(edges: list[tuple[int, bool]]) -> list[int]:
    """Times of rising edges."""
    return [when for when, level in edges if level]
