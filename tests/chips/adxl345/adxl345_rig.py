"""An ADXL345 on a bench: a world given by a function, SPI and I²C by hand, time by hand."""

from __future__ import annotations

from collections.abc import Callable
from struct import unpack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.chips.adxl345 import Adxl345
from hal.emulated.pins import Net
from hal.emulated.virtual_time import VirtualTime

US, MS, SECOND = 1_000, 1_000_000, 1_000_000_000
G = 9.80665

Motion = Callable[[NDArray[np.float64]], dict[str, Any]]


def at_rest(_t: NDArray[np.float64]) -> dict[str, Any]:
    """Flat on a table, top side up: specific force points up."""
    return {"fz": G}


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
        assert times_ns[0] > self._last - 8 * SECOND
        self._last = int(times_ns[-1])
        self.calls.append((int(times_ns[0]), int(times_ns[-1]), len(times_ns), bandwidth_hz))
        values = np.zeros((len(times_ns), 7))
        for name, value in self.motion(times_ns * 1e-9).items():
            values[:, ("fx", "fy", "fz").index(name)] = value
        return values


class Rig:
    """Chip, world, nets and a hand on the clock."""

    def __init__(
        self, motion: Motion = at_rest, *, listen: str = "", byte_ns: int = 5 * US, **options: Any
    ) -> None:
        self.time = VirtualTime()
        self.world = BenchWorld(motion)
        self.chip = Adxl345(self.time, self.world, **options)
        self.byte_ns = byte_ns
        """5 µs: a clock of 1.6 MHz."""
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
        """One transaction on the wire, and a pause after it."""
        start = self.time.now
        end = start + len(mosi) * self.byte_ns
        miso = self.chip.transaction(mosi, start, end)
        assert len(miso) == len(mosi)
        self.until(end + US)
        return miso

    def read(self, register: int, count: int = 1) -> bytes:
        """Burst read."""
        return self.spi(bytes((0x80 | 0x40 * (count > 1) | register,)) + bytes(count))[1:]

    def byte(self, register: int) -> int:
        """One register."""
        return self.read(register)[0]

    def write(self, register: int, *values: int) -> None:
        """Burst write."""
        self.spi(bytes((0x40 * (len(values) > 1) | register, *values)))

    def xyz(self) -> tuple[int, ...]:
        """The data registers as counts."""
        return unpack("<3h", self.read(0x32, 6))

    def measure(self, rate: int = 0x0A, data_format: int = 0x0B, power: int = 0x08) -> int:
        """Set up and start; returns the instant at which the turn-on time begins."""
        self.write(0x31, data_format)
        self.write(0x2C, rate)
        start = self.time.now + 2 * self.byte_ns
        self.write(0x2D, power)
        return start


def rising(edges: list[tuple[int, bool]]) -> list[int]:
    """Times of rising edges."""
    return [when for when, level in edges if level]
