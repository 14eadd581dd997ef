"""Chip models behind the emulated bridge."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from desk_world import Desk
from emulated_bus_pirate import EmulatedBusPirate, WallTime
from pty_port import PtyPort

from boards.chips.adxl345 import Adxl345
from boards.chips.bmi160 import Bmi160

MODELS: dict[str, Any] = {"bmi160": Bmi160, "adxl345": Adxl345}
MEASURE = {
    "bmi160": (b"\xff\x00", b"\x7e\x11", b"\x7e\x15", b"\x8c" + bytes(15)),
    "adxl345": (b"\x2d\x08", b"\xf2" + bytes(6), b"\xb9\x00"),
}
"""What brings the chips to their first sample."""


def compile_the_model(name: str) -> None:
    """The model's first sample may take seconds, which no chip does."""
    wall = WallTime()
    chip = MODELS[name](wall.virtual, Desk())
    now = 20_000_000
    for mosi in MEASURE[name]:
        wall.virtual.now = now
        chip.transaction(mosi, now, now + 20_000)
        now += 100_000_000


class Desktop:
    """A bridge at a port, with a chip on both of its buses that it feeds."""

    def __init__(self, path: Path, name: str = "bmi160", **options: Any) -> None:
        compile_the_model(name)
        wall = WallTime()
        self.chip = MODELS[name](wall.virtual, Desk(), **options)
        face = self.chip.i2c
        self.pirate = EmulatedBusPirate(
            wall, spi=self.chip, i2c={face.address: face}, supply=getattr(self.chip, "power", None)
        )
        self.port = PtyPort(path, self.pirate.feed)
        self.url = str(self.port.path)

    def __enter__(self) -> Desktop:
        return self

    def __exit__(self, *_: object) -> None:
        self.port.unplug()
