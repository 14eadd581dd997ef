"""An HMC6343 on a bench: a world given by a function, an emulated I²C bus at 100 kHz, time by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.chips.hmc6343 import Hmc6343
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.pins import Net
from hal.emulated.virtual_time import VirtualTime

US, MS, SECOND = 1_000, 1_000_000, 1_000_000_000
G = 9.80665
MILLIGAUSS = 1e-7
HORIZONTAL, DOWN = 200.0, 430.0
"""mgauss: the Earth's field in central Europe."""
ADDRESS = 0x19

Motion = Callable[[float], tuple[float, float, float]]
"""Time (s) -> heading, pitch, roll (degrees)."""


def rotation(heading: float, pitch: float, roll: float) -> NDArray[np.float64]:
    """C_nb of Z-Y-X Euler angles in degrees, north-east-down and forward-right-down."""
    psi, theta, phi = np.radians((heading, pitch, roll))
    about_x = [[1, 0, 0], [0, np.cos(phi), -np.sin(phi)], [0, np.sin(phi), np.cos(phi)]]
    about_y = [[np.cos(theta), 0, np.sin(theta)], [0, 1, 0], [-np.sin(theta), 0, np.cos(theta)]]
    about_z = [[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]]
    return np.array(about_z) @ np.array(about_y) @ np.array(about_x)


MOUNTINGS = {
    "level": np.diag([1.0, -1.0, -1.0]),
    "edge": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    "front": np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]),
}
"""C_b_s: forward, right, down of the body out of the chip's x, y, z. Level: x forward, z up; edge: x forward,
y up; front: z forward, −x up."""


class BenchWorld:
    """The CompassWorld of a body that turns, at rest otherwise; holds every caller to the contract."""

    def __init__(self, motion: Motion, mounting: str = "level", iron: tuple[float, ...] = (0, 0, 0)) -> None:
        self.motion = motion
        self.temperature = 25.0
        self.calls = 0
        self._c_sb = MOUNTINGS[mounting].T
        self._iron = np.array(iron) * MILLIGAUSS
        self._last = -1

    def sample(self, times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """See boards.chips.world.CompassWorld."""
        assert times_ns.dtype == np.int64
        assert times_ns[0] > self._last
        assert (np.diff(times_ns) > 0).all()
        self._last = int(times_ns[-1])
        self.calls += 1
        values = np.zeros((len(times_ns), 7))
        for row, when in zip(values, times_ns.tolist(), strict=True):
            c_nb = rotation(*self.motion(when * 1e-9))
            row[:3] = self._c_sb @ c_nb.T @ [0.0, 0.0, -G]
            field = np.array([HORIZONTAL, 0.0, DOWN]) * MILLIGAUSS
            row[3:6] = self._c_sb @ c_nb.T @ field + self._iron
            row[6] = self.temperature
        return values


class Rig:
    """Chip, bus and a hand on the clock."""

    def __init__(
        self,
        motion: Motion = lambda t: (30.0, 0.0, 0.0),
        *,
        mounting: str = "level",
        iron: tuple[float, ...] = (0, 0, 0),
        frequency_hz: int = 100_000,
        **options: Any,
    ) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "mcu", 100_000_000)
        self.world = BenchWorld(motion, mounting, iron)
        self.chip = Hmc6343(self.time, self.world, **options)
        self.bus = EmulatedI2cBus(self.cpu, frequency_hz)
        self.bus.attach(self.chip.i2c.address, self.chip.i2c)
        self.net = Net(self.time, "DRDY")
        self.chip.pins["DRDY"] = self.net

    def until(self, end_ns: int) -> None:
        """Let time pass to an instant; events run."""
        self.cpu.wait_until(end_ns)

    def wait(self, duration_ns: int) -> None:
        """Let time pass."""
        self.cpu.delay(duration_ns)

    def start(self) -> None:
        """Past power-up."""
        self.until(max(self.time.now, 500 * MS))

    def command(self, *data: int, delay_ns: int = 1 * MS) -> None:
        """A command and its delay."""
        self.bus.transaction(ADDRESS, bytes(data))
        self.wait(delay_ns)

    def ask(self, *data: int, length: int = 6, delay_ns: int = 1 * MS) -> bytes:
        """A command and its response."""
        self.command(*data, delay_ns=delay_ns)
        return self.bus.transaction(ADDRESS, b"", length)

    def words(self, *data: int) -> list[int]:
        """A response of three words."""
        answer = self.ask(*data)
        return [int.from_bytes(answer[k : k + 2], "big", signed=True) for k in (0, 2, 4)]

    def peek(self, address: int) -> int:
        """A byte of the EEPROM."""
        return self.ask(0xE1, address, length=1, delay_ns=10 * MS)[0]

    def poke(self, address: int, value: int) -> None:
        """Write a byte of the EEPROM."""
        self.command(0xF1, address, value, delay_ns=10 * MS)

    def reset(self) -> None:
        """The reset command and its time."""
        self.command(0x82, delay_ns=500 * MS)

    @property
    def details(self) -> list[str]:
        """What was reported."""
        return [report.detail for report in self.chip.reports]
