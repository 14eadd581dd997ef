"""Chip models behind the emulated bridge."""

from __future__ import annotations

from pathlib import Path

from desk_world import Desk
from emulated_bus_pirate import EmulatedBusPirate, WallTime
from pty_port import PtyPort

from boards.chips.bmi160 import Bmi160 as ChipModel


def bmi160_bridge() -> tuple[EmulatedBusPirate, ChipModel]:
    """A BMI160 on both buses of one bridge, fed by it."""
    wall = WallTime()
    chip = ChipModel(wall.virtual, Desk())
    pirate = EmulatedBusPirate(wall, spi=chip, i2c={chip.i2c.address: chip.i2c}, supply=chip.power)
    return pirate, chip


def compile_the_model() -> None:
    """The model's first sample may take seconds, which no chip does."""
    wall = WallTime()
    chip = ChipModel(wall.virtual, Desk())
    now = 20_000_000
    for mosi in (b"\xff\x00", b"\x7e\x11", b"\x7e\x15", b"\x8c" + bytes(15)):
        wall.virtual.now = now
        chip.transaction(mosi, now, now + 20_000)
        now += 100_000_000


class Desktop:
    """A bridge with a BMI160 at a port."""

    def __init__(self, path: Path) -> None:
        compile_the_model()
        self.pirate, self.chip = bmi160_bridge()
        self.port = PtyPort(path, self.pirate.feed)
        self.url = str(self.port.path)

    def __enter__(self) -> Desktop:
        return self

    def __exit__(self, *_: object) -> None:
        self.port.unplug()
