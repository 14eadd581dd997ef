"""luma.oled from PyPI, unmodified: what it draws is what one sees. Skipped where it is not installed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from boards.chips.ssd1325 import Ssd1325
from hal.emulated.pins import Net
from hal.emulated.virtual_time import VirtualTime


class Wires:
    """What luma calls a serial interface."""

    def __init__(self) -> None:
        time = VirtualTime()
        self.chip = Ssd1325(time)
        self._data_or_command = Net(time, "DC")
        self.chip.pins["DC"] = self._data_or_command

    def command(self, *values: int) -> None:
        self._transfer(False, bytes(values))

    def data(self, values: Any) -> None:
        self._transfer(True, bytes(values))

    def cleanup(self) -> None:
        """Nothing is held."""

    def _transfer(self, is_data: bool, data: bytes) -> None:
        self._data_or_command.set(is_data)
        self.chip.transaction(data, 0, 800 * len(data))


@pytest.mark.filterwarnings("ignore:.*getdata:DeprecationWarning")  # what luma asks of Pillow
@pytest.mark.parametrize("rotate", [0, 2])
@pytest.mark.parametrize("mode", ["RGB", "1"])
def test_a_picture_of_luma_stands_on_the_glass(mode: str, rotate: int) -> None:
    device = pytest.importorskip("luma.oled.device")
    image = pytest.importorskip("PIL.Image").new(mode, (128, 64))
    draw = pytest.importorskip("PIL.ImageDraw").Draw(image)
    draw.rectangle((3, 2, 40, 10), fill="white")
    draw.line((0, 63, 127, 30), fill="white")
    draw.text((50, 20), "gfsins", fill="white")
    if mode == "RGB":
        draw.rectangle((60, 50, 80, 60), fill=(120, 120, 120))
    wires = Wires()
    panel = device.ssd1325(wires, mode=mode, rotate=rotate)
    panel.display(image)
    wanted = np.asarray(image.convert("L").rotate(90 * rotate)) // 16
    assert set(np.unique(wanted)) >= {0, 15}
    assert np.array_equal(wires.chip.picture(), wanted)
    assert wires.chip.reports == []
    panel.hide()
    assert not wires.chip.picture().any()
    panel.show()
    assert np.array_equal(wires.chip.picture(), wanted)
