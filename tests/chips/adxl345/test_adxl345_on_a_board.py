"""Seven chips on one SPI controller of a described board, polled at 200 Hz by our driver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from adxl345_rig import BenchWorld, G

from boards.assembly import assemble
from boards.description import load_board
from boards.validation import DescriptionError
from firmware.drivers.adxl345 import Adxl345, Adxl345Config, Outcome
from firmware.drivers.adxl345_ports import SpiPort
from host.sim.errors.presets import load_preset

RATE_HZ, CHIPS = 200, 7

BOARD = """
name = "seven"
title = "seven accelerometers"
default_profile = "plain"
default_scenario = "none"
[processors.mcu]
part = "STM32F405"
clock_hz = 168_000_000
program = "test_adxl345_on_a_board:program"
tasks = { tick = { priority = 2 } }
[buses.spi1]
kind = "spi"
processor = "mcu"
clock_hz = 5_000_000
mode = %MODE%
[timers.tick]
processor = "mcu"
[profiles.plain]
"""
CHIP = """
[chips.U%K%]
part = "ADXL345"
model = "boards.chips.adxl345:Adxl345"
bus = "spi1"
name = "acc%K%"
world = "imu"
errors = "adxl345"
parameters = { clock_error_ppm = %PPM%, strict = true }
"""


class Seven:
    """Reads every chip at each tick."""

    def __init__(self, io: Any) -> None:
        self.io = io
        config = Adxl345Config(rate_hz=RATE_HZ)
        self.chips = [Adxl345(SpiPort(io.spi[f"acc{k}"]), io.cpu, config) for k in range(CHIPS)]
        self.outcomes: list[Outcome] = []
        self.z: list[list[int]] = []

    def main(self) -> None:
        self.outcomes = [chip.start() for chip in self.chips]
        self.io.timers["tick"].start(RATE_HZ, self.io.interrupts.attach("tick", self.on_tick))
        while True:
            self.io.cpu.wait_for_interrupt()

    def on_tick(self) -> None:
        for chip in self.chips:
            chip.read()
        self.z.append([int(chip.raw[5:7].view("<i2")[0]) for chip in self.chips])

    def spoil(self) -> None:
        """Nothing to spoil."""

    def memory(self) -> bytes:
        return bytes(len(self.z) & 0xFF)


def program(io: Any, _profile: Any, _installation: Any) -> Seven:
    return Seven(io)


class Places:
    """Each chip feels another constant."""

    def __init__(self) -> None:
        self.worlds: dict[str, BenchWorld] = {}

    def imu(self, refdes: str, _chip: Any) -> BenchWorld:
        level = 0.1 * int(refdes[1:])
        self.worlds[refdes] = BenchWorld(lambda t: {"fz": level * G + 0.0 * t})
        return self.worlds[refdes]

    def gnss(self, refdes: str, _chip: Any) -> Any:
        raise AssertionError(refdes)

    def log_sink(self, name: str) -> Any:
        raise AssertionError(name)


def described(folder: Path, mode: int = 3) -> Any:
    text = BOARD.replace("%MODE%", str(mode))
    for k in range(CHIPS):
        text += CHIP.replace("%K%", str(k)).replace("%PPM%", str(100.0 * k))
    (folder / "seven").mkdir()
    (folder / "seven" / "board.toml").write_text(text)
    return load_board(str(folder / "seven"))


def test_seven_chips_polled_at_200_hz(tmp_path: Path) -> None:
    places = Places()
    board = assemble(described(tmp_path), {}, places)
    board.machine.run_until(10_000_000_000)
    program = board.programs["mcu"]
    board.machine.power_off()
    assert isinstance(program, Seven)
    assert program.outcomes == [Outcome.OK] * CHIPS
    assert len(program.z) == pytest.approx(10 * RATE_HZ, abs=30)
    assert (np.array(program.z) == [round(25.6 * k) for k in range(CHIPS)]).all()
    assert all(board.chips[f"U{k}"].reports == [] for k in range(CHIPS))
    assert max(len(world.calls) for world in places.worlds.values()) <= 5  # asked for seconds at a time


def test_another_clock_mode_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="ADXL345 works in SPI modes 3"):
        assemble(described(tmp_path, mode=0), {}, Places())


def test_preset_holds_the_noise_of_the_sheet() -> None:
    noise = load_preset("adxl345").accelerometer.noise_ug_per_rthz
    counts = np.array(noise) * 1e-6 * np.sqrt(100.0) * 256.0
    assert counts == pytest.approx([0.75, 0.75, 1.1], rel=0.015)
