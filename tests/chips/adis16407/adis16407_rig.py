"""An ADIS16407 on a bench: a world given by a function, words by hand, time by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.chips.adis16407 import Adis16407
from hal.emulated.pins import Net
from hal.emulated.virtual_time import VirtualTime

US, MS, SECOND = 1_000, 1_000_000, 1_000_000_000
G = 9.80665
START_UP = 210 * MS
COLUMNS = ("fx", "fy", "fz", "wx", "wy", "wz", "temperature", "bx", "by", "bz", "pressure")

Motion = Callable[[NDArray[np.float64]], dict[str, Any]]


def at_rest(_t: NDArray[np.float64]) -> dict[str, Any]:
    """Flat on a table, z up: 1 g, 25 °C, 1000 mbar."""
    return {}


class BenchWorld:
    """The TenDofWorld of a function of time in seconds (rates in °/s, field in gauss, pressure in mbar);
    holds every caller to the contract."""

    def __init__(self, motion: Motion = at_rest) -> None:
        self.motion = motion
        self.calls: list[tuple[int, int, int]] = []
        """(first ns, last ns, samples) of every call."""
        self._last = -1

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> NDArray[np.float64]:
        assert times_ns.dtype == np.int64
        assert len(times_ns) > 0
        assert bandwidth_hz == 330.0
        assert (np.diff(times_ns) > 0).all()
        assert times_ns[0] > self._last - 8 * SECOND
        self._last = int(times_ns[-1])
        self.calls.append((int(times_ns[0]), self._last, len(times_ns)))
        values = np.zeros((len(times_ns), 11))
        felt = {"fz": G, "temperature": 25.0, "pressure": 1000.0} | self.motion(times_ns * 1e-9)
        for name, value in felt.items():
            values[:, COLUMNS.index(name)] = value
        values[:, 3:6] = np.radians(values[:, 3:6])
        values[:, 7:10] *= 1e-4
        values[:, 10] *= 100.0
        return values


class Rig:
    """Chip, world, nets and a hand on the clock. Words at 1 MHz, 24 µs between them."""

    def __init__(
        self, motion: Motion = at_rest, *, listen: str = "", started: bool = True, **options: Any
    ) -> None:
        self.time = VirtualTime()
        self.world = BenchWorld(motion)
        self.chip = Adis16407(self.time, self.world, **options)
        self.nets = {name: Net(self.time, name) for name in ("DIO1", "DIO2", "DIO3", "DIO4", "RST")}
        self.edges: dict[str, list[tuple[int, bool]]] = {name: [] for name in self.nets}
        for name, net in self.nets.items():
            self.chip.pins[name] = net
            if name in listen.split():
                net.listen(lambda level, when, name=name: self.edges[name].append((when, level)))  # type: ignore[misc]
        if started:
            self.until(START_UP)

    def wait(self, duration_ns: int) -> None:
        """Let time pass; events run."""
        self.until(self.time.now + duration_ns)

    def until(self, end_ns: int) -> None:
        """Let time pass to an instant."""
        while self.time.next_due <= end_ns:
            self.time.run_next()
        self.time.now = end_ns

    def spi(self, mosi: bytes, duration_ns: int | None = None) -> bytes:
        """One transaction on the wire, and a pause after it."""
        start = self.time.now
        end = start + (len(mosi) * 8 * US if duration_ns is None else duration_ns)
        miso = self.chip.transaction(mosi, start, end)
        assert len(miso) == len(mosi)
        self.until(end + 24 * US)
        return miso

    def word(self, value: int) -> int:
        """One word with chip select of its own."""
        return int.from_bytes(self.spi(value.to_bytes(2, "big")), "big")

    def read(self, address: int) -> int:
        """A register, by two words."""
        self.word(address << 8)
        return self.word(address << 8)

    def write(self, address: int, value: int) -> None:
        """Both bytes, the low one first."""
        self.word(0x8000 | address << 8 | value & 0xFF)
        self.word(0x8000 | address + 1 << 8 | value >> 8)

    def burst(self) -> list[int]:
        """The 14 outputs."""
        miso = self.spi(b"\x42" + bytes(29), 254 * US)
        return [int.from_bytes(miso[k : k + 2], "big") for k in range(2, 30, 2)]


def instant(n: int, start_ns: int = START_UP) -> int:
    """The n-th sample at 819.2 Hz."""
    return start_ns + n * 10**9 * 5 // 4096
