"""The SSD1325 driver: byte by byte as written down, and on the chip model's bus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from boards.chips.ssd1325 import Ssd1325 as DisplayModel
from firmware.drivers.ssd1325 import Ssd1325
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.pins import EmulatedOutputPin, Net
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import VirtualTime
from hal.scripted.cpu import ScriptedCpu
from hal.scripted.pins import ScriptedOutput
from hal.scripted.spi import ScriptedSpi
from hal.scripted.transcript import Transcript

GOLDEN = Path(__file__).parents[1] / "chips" / "ssd1325" / "ssd1325_golden.txt"
CLOCK_HZ = 4_000_000


class Desk:
    """Driver and model on a bus in virtual time; the test is the program."""

    def __init__(self, strict: bool = True) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "fpga", 70_000_000)
        self.model = DisplayModel(self.time, strict=strict)
        self.bus = EmulatedSpiBus(self.cpu, SpiTiming(CLOCK_HZ), "panel")
        data, reset = Net(self.time, "DC"), Net(self.time, "RES")
        self.model.pins |= {"DC": data, "RES": reset}
        self.model.wired()
        pins = EmulatedOutputPin(self.cpu, data), EmulatedOutputPin(self.cpu, reset)
        device = self.bus.device(self.model, "display")
        device.observer = self._note
        self.driver = Ssd1325(device, *pins, self.cpu)
        self.bytes_sent = 0

    def _note(self, _start_ns: int, _end_ns: int, mosi: bytes | bytearray, _miso: bytes | bytearray) -> None:
        self.bytes_sent += len(mosi)


def test_driver_asks_the_golden_transcript() -> None:
    transcript = Transcript(GOLDEN.read_text())
    pins = ScriptedOutput(transcript, "DC"), ScriptedOutput(transcript, "RES")
    display = Ssd1325(ScriptedSpi(transcript, "display"), *pins, ScriptedCpu(transcript))
    with transcript:
        display.start()
        display.put(5, 9, 2, bytes((0x12, 0x34, 0x56, 0x78)))
        display.restore()
        display.stop()


def test_model_shows_the_golden_transcript() -> None:
    """Played without the driver, up to the last line that switches it off."""
    time = VirtualTime()
    model = DisplayModel(time, strict=True)
    nets = {name: Net(time, name) for name in ("DC", "RES")}
    model.pins |= nets
    model.wired()
    *lines, last = [line for line in GOLDEN.read_text().splitlines() if not line.startswith("#")]
    for line in lines:
        kind, *words = line.split()
        if kind == "pin":
            nets[words[0]].set(words[1] == "high")
        elif kind == "spi":
            sent = bytes.fromhex("".join(words[1 : words.index("->")]))
            assert model.transaction(sent, 0, 0).hex(" ") == line.partition("-> ")[2]
    assert model.picture()[9:11, 10:14].tolist() == [[1, 2, 3, 4], [5, 6, 7, 8]]
    assert np.count_nonzero(model.picture()) == 8
    assert "ae" in last


def test_blocks_stand_where_they_were_put_and_take_their_time_on_the_wire() -> None:
    desk = Desk()
    desk.driver.start()
    assert not desk.model.picture().any()
    random = np.random.default_rng(5)
    wanted = np.zeros((64, 128), np.uint8)
    for _ in range(40):
        column, row = int(random.integers(64)), int(random.integers(64))
        columns, rows = int(random.integers(1, 65 - column)), int(random.integers(1, 65 - row))
        levels = random.integers(0, 16, (rows, 2 * columns), np.uint8)
        wanted[row : row + rows, 2 * column : 2 * (column + columns)] = levels
        before_ns = desk.time.now
        desk.driver.put(column, row, columns, (levels[:, 0::2] << 4 | levels[:, 1::2]).tobytes())
        bits = 8 * (6 + rows * columns)
        assert desk.time.now - before_ns >= bits * 1_000_000_000 // CLOCK_HZ
    assert np.array_equal(desk.model.picture(), wanted)
    desk.driver.fill(1, 2, 3, 4, 0xAA)
    wanted[2:6, 2:8] = 0xA
    assert np.array_equal(desk.model.picture(), wanted)
    assert desk.model.reports == []


@pytest.mark.parametrize(
    "cut", [b"\x15", b"\x15\x03", b"\xb8\x01\x02", b"\x24\x00\x00\x10", b"\xa0", b"\xa8"]
)
def test_restore_ends_a_command_whose_arguments_were_lost(cut: bytes) -> None:
    """What the command made of the wrong arguments is drawn over by whoever draws everything anew."""
    desk = Desk(strict=False)
    desk.driver.start()
    desk.model.pins["DC"].level = False  # type: ignore[union-attr]
    desk.model.transaction(cut, 0, 0)
    desk.driver.restore()
    wanted = np.random.default_rng(3).integers(0, 16, (64, 128), np.uint8)
    desk.driver.put(0, 0, 64, (wanted[:, 0::2] << 4 | wanted[:, 1::2]).tobytes())
    assert np.array_equal(desk.model.picture(), wanted)


def test_a_display_that_lost_its_supply_shows_again_after_restore() -> None:
    desk = Desk()
    desk.driver.start()
    desk.model.power(False)
    desk.driver.put(0, 0, 1, b"\xff")
    desk.model.power(True)
    assert not desk.model.picture().any()
    desk.driver.restore()
    desk.driver.put(0, 0, 1, b"\xff")
    assert desk.model.picture()[0, :2].tolist() == [15, 15]
    desk.driver.stop()
    assert not desk.model.picture().any()


def test_an_absent_display_is_no_error() -> None:
    class Nobody:
        def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
            return b"\x00" * len(mosi)

    desk = Desk()
    pins = [EmulatedOutputPin(desk.cpu, Net(desk.time, name)) for name in ("A", "B")]
    driver = Ssd1325(desk.bus.device(Nobody(), "nobody"), *pins, desk.cpu)
    driver.start()
    driver.put(0, 0, 64, bytes(64))
    driver.restore()


@pytest.mark.parametrize(
    ("block", "told"),
    [
        ((0, 0, 65, bytes(65)), "a block of 65 × 1 at column 0, row 0 does not lie in 64 × 64"),
        ((63, 0, 2, bytes(2)), "a block of 2 × 1 at column 63"),
        ((0, 63, 1, bytes(2)), "a block of 1 × 2 at column 0, row 63"),
        ((-1, 0, 1, bytes(1)), "column -1"),
        ((0, 0, 2, bytes(3)), "3 bytes are no whole rows of 2"),
        ((0, 0, 0, b""), "0 bytes are no whole rows of 0"),
        ((0, 0, 3, b""), "a block of 3 × 0"),
    ],
)
def test_a_block_that_lies_outside_is_refused(block: tuple[int, int, int, bytes], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        Desk().driver.put(*block)
