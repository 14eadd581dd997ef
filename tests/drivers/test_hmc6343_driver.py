"""The HMC6343 driver: transaction by transaction as the sheet wants it, and on the chip model's bus."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from boards.chips.hmc6343 import Hmc6343 as ChipModel
from firmware.drivers import hmc6343_sample as sample
from firmware.drivers.hmc6343 import Hmc6343, Hmc6343Config, Outcome
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.virtual_time import VirtualTime
from hal.scripted.cpu import ScriptedCpu
from hal.scripted.i2c import ScriptedI2c
from hal.scripted.transcript import Transcript

MS, SECOND = 1_000_000, 1_000_000_000
GOLDEN = Path(__file__).parents[1] / "chips" / "hmc6343" / "hmc6343_golden.txt"


def scripted(text: str, config: Hmc6343Config | None = None) -> tuple[Transcript, Hmc6343]:
    transcript = Transcript(text)
    bus = ScriptedI2c(transcript, "compass")
    return transcript, Hmc6343(bus, ScriptedCpu(transcript), config or Hmc6343Config())


def test_driver_asks_the_golden_transcript() -> None:
    """The one that the model answers in tests/chips/hmc6343."""
    config = Hmc6343Config(rate_hz=10, filter=2, variation=23, deviation=-5)
    transcript, chip = scripted(GOLDEN.read_text(), config)
    angles = np.zeros(sample.ANGLES_SIZE, np.float32)
    with transcript:
        assert chip.start() is Outcome.OK
        for heading in (13.6, 14.2, 14.9):
            assert chip.read()
            sample.convert(chip.raw, angles)
            assert np.degrees(angles) == pytest.approx([heading, 5.0, -12.0], abs=1e-4)
            chip._cpu.delay(100 * MS)
        assert chip.temperature() == 25.0
        assert chip.vectors() == ((89, -212, 998), (1552, 1424, -4249))
        assert chip.check() is Outcome.OK
        assert chip.sleep()
        assert chip.start() is Outcome.OK


POWER_UP = "delay 500000000\ni2c compass 19 write 84\ndelay 20000000\n"


@pytest.mark.parametrize(
    ("text", "outcome"),
    [
        (
            "delay 500000000\ni2c compass 19 write 84 -> address-nack\n"
            "i2c compass 19 write e1 00 -> address-nack",
            Outcome.ABSENT,
        ),
        (
            POWER_UP + "i2c compass 19 write e1 00\ndelay 10000000\ni2c compass 19 read 1 -> 3c",
            Outcome.WRONG_CHIP,
        ),
        (
            POWER_UP + "i2c compass 19 write e1 00\ndelay 10000000\ni2c compass 19 read 1 -> timeout",
            Outcome.ABSENT,
        ),
    ],
)
def test_start_tells_what_is_wrong(text: str, outcome: Outcome) -> None:
    transcript, chip = scripted(text)
    with transcript:
        assert chip.start() is outcome


@pytest.mark.parametrize(
    ("mode", "outcome"),
    [
        ("11", Outcome.OK),
        ("91", Outcome.OK),
        ("09", Outcome.NOT_RUNNING),
        ("12", Outcome.NOT_RUNNING),
    ],
)
def test_check(mode: str, outcome: Outcome) -> None:
    text = f"i2c compass 19 write 65\ndelay 1000000\ni2c compass 19 read 1 -> {mode}"
    transcript, chip = scripted(text)
    with transcript:
        assert chip.check() is outcome


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate_hz": 2}, "rate_hz is 2; possible: 1, 5, 10"),
        ({"rate_hz": True}, "rate_hz is True"),
        ({"orientation": "flat"}, "orientation is 'flat'; possible: 'level', 'edge', 'front'"),
        ({"filter": 16}, "filter is 16"),
        ({"variation": 1801}, "variation is 1801; possible: -1800 to 1800"),
    ],
)
def test_settings_the_part_does_not_have(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Hmc6343Config(**change)


# -- against the chip model ------------------------------------------------------------------------------


class World:
    """A CompassWorld of a level body: x forward, z up, heading in degrees, hard iron (T) in the chip."""

    def __init__(self, heading: float) -> None:
        self.heading = heading
        self.turn_dps = 0.0
        self.iron = np.zeros(3)

    def sample(self, times_ns: Any) -> Any:
        values = np.zeros((len(times_ns), 7))
        psi = np.radians(self.heading + self.turn_dps * times_ns * 1e-9)
        values[:, 2] = 9.80665
        values[:, 3], values[:, 4] = 2e-5 * np.cos(psi), 2e-5 * np.sin(psi)
        values[:, 5] = -4.3e-5
        values[:, 3:6] += self.iron
        values[:, 6] = 21.5
        return values


class Board:
    """A processor with the part on its I²C bus."""

    def __init__(self, heading: float = 123.4, **options: Any) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "mcu", 168_000_000)
        self.world = World(heading)
        self.model = ChipModel(self.time, self.world, strict=True, **options)
        self.bus = EmulatedI2cBus(self.cpu, 100_000)
        self.bus.attach(self.model.i2c.address, self.model.i2c)

    def driver(self, **config: Any) -> Hmc6343:
        return Hmc6343(self.bus, self.cpu, Hmc6343Config(**config))


def heading_of(chip: Hmc6343) -> float:
    angles = np.zeros(3, np.float32)
    assert chip.read()
    sample.convert(chip.raw, angles)
    return float(np.degrees(angles[sample.HEADING]))


@pytest.mark.parametrize("rate_hz", [1, 5, 10])
@pytest.mark.parametrize("orientation", ["level", "edge", "front"])
def test_starts_from_the_factory_and_again(rate_hz: int, orientation: str) -> None:
    board = Board()
    chip = board.driver(rate_hz=rate_hz, orientation=orientation, filter=3)
    for _ in range(2):
        assert chip.start() is Outcome.OK
        assert chip.check() is Outcome.OK
        assert chip.temperature() == 21.5


def test_reads_with_variation() -> None:
    board = Board(heading=359.0)
    chip = board.driver(variation=25)
    assert chip.start() is Outcome.OK
    assert heading_of(chip) == pytest.approx(1.5, abs=0.06)


def test_wakes_what_an_earlier_program_put_to_sleep() -> None:
    board = Board()
    assert board.driver().start() is Outcome.OK
    assert board.driver().sleep()
    chip = board.driver(rate_hz=10)
    assert chip.start() is Outcome.OK
    board.cpu.delay(200 * MS)
    assert heading_of(chip) == pytest.approx(123.4, abs=0.06)


def test_calibration() -> None:
    board = Board(heading=0.0)
    chip = board.driver(rate_hz=10)
    assert chip.start() is Outcome.OK
    board.world.iron = np.array([1e-5, -2e-5, 0.0])
    assert chip.begin_calibration()
    board.world.turn_dps = 36.0
    board.cpu.delay(12 * SECOND)
    assert chip.end_calibration()
    board.world.turn_dps = 0.0
    board.cpu.delay(200 * MS)
    assert min(heading_of(chip), 360.0 - heading_of(chip)) < 2.0


def test_supply_lost_and_back() -> None:
    board = Board()
    chip = board.driver()
    assert chip.start() is Outcome.OK
    board.model.power(False)
    assert chip.read() is False
    assert chip.temperature() is None
    assert chip.vectors() is None
    assert chip.check() is Outcome.ABSENT
    assert chip.start() is Outcome.ABSENT
    board.model.power(True)
    assert chip.start() is Outcome.OK
    assert board.model.reports == []


# -- conversion --------------------------------------------------------------------------------------


@given(some.integers(0, 3599), some.integers(-900, 900), some.integers(-900, 900))
def test_conversion(heading: int, pitch: int, roll: int) -> None:
    words = b"".join(value.to_bytes(2, "big", signed=True) for value in (heading, pitch, roll))
    angles = np.zeros(3, np.float32)
    sample.convert(np.frombuffer(words, np.uint8).copy(), angles)
    assert angles == pytest.approx(np.radians(np.array([heading, pitch, roll]) / 10.0), rel=3e-7)
