"""The ADXL345 driver: transaction by transaction as the sheet wants it, and on the chip model's buses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from boards.chips.adxl345 import Adxl345 as ChipModel
from firmware.drivers import adxl345_sample as sample
from firmware.drivers.adxl345 import Adxl345, Adxl345Config, Outcome
from firmware.drivers.adxl345_ports import ADDRESS, ALTERNATIVE_ADDRESS, I2cPort, RegisterPort, SpiPort
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.pins import EmulatedInputPin, Net
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import VirtualTime
from hal.pins import Edge
from hal.scripted.cpu import ScriptedCpu
from hal.scripted.i2c import ScriptedI2c
from hal.scripted.spi import ScriptedSpi
from hal.scripted.transcript import Transcript

G = 9.80665
MS = 1_000_000
GOLDEN = Path(__file__).parents[1] / "chips" / "adxl345" / "adxl345_golden.txt"


# -- against written transcripts -------------------------------------------------------------------


def scripted(text: str, config: Adxl345Config | None = None) -> tuple[Transcript, Adxl345]:
    transcript = Transcript(text)
    port = SpiPort(ScriptedSpi(transcript, "adxl"))
    return transcript, Adxl345(port, ScriptedCpu(transcript), config or Adxl345Config())


def test_driver_asks_the_golden_transcript() -> None:
    """The one that the model answers in tests/chips/adxl345."""
    transcript = Transcript(GOLDEN.read_text())
    port, cpu = SpiPort(ScriptedSpi(transcript, "adxl")), ScriptedCpu(transcript)
    with transcript:
        chip = Adxl345(port, cpu, Adxl345Config(interrupt_pin=1))
        assert chip.start() is Outcome.OK
        seen = []
        for _ in range(3):
            assert chip.read()
            seen.append(chip.raw[1:].view("<i2").tolist())
            cpu.delay(10 * MS)
        assert seen == [[1, -64, 256], [2, -64, 256], [3, -64, 256]]
        assert chip.check() is Outcome.OK
        config = Adxl345Config(
            rate_hz=200, range_g=4, fifo="stream", watermark=8, interrupt_pin=2, offsets=(0, 16, -1)
        )
        chip = Adxl345(port, cpu, config)
        assert chip.start() is Outcome.OK
        cpu.delay(20 * MS)
        assert chip.read_fifo() == 5
        assert chip.fifo[:5, 1].tolist() == [5, 5, 6, 6, 7]
        assert chip.self_test() is Outcome.OK


BEGIN = "spi adxl 2d 00 -> 00 00\nspi adxl 31 0b -> 00 00\nspi adxl 80 00 -> 00 {id}\n"
WRITES = "2e 00, 38 00, 31 0b, 2c 0a, 1e 00, 1f 00, 20 00, 2f 00, 38 10, 2e 00, 2d 08"
CONFIGURE = BEGIN.format(id="e5") + "".join(f"spi adxl {pair} -> 00 00\n" for pair in WRITES.split(", "))


@pytest.mark.parametrize(
    ("text", "outcome", "detail"),
    [
        (BEGIN.format(id="ff"), Outcome.ABSENT, 0xFF),
        (BEGIN.format(id="00"), Outcome.ABSENT, 0x00),
        (BEGIN.format(id="e6"), Outcome.WRONG_CHIP, 0xE6),
        (CONFIGURE + "spi adxl b1 00 -> 00 03", Outcome.NOT_CONFIGURED, 0x03),
        (CONFIGURE + "spi adxl b1 00 -> 00 0b\nspi adxl ac 00 -> 00 0b", Outcome.NOT_CONFIGURED, 0x0B),
    ],
)
def test_start_tells_what_is_wrong(text: str, outcome: Outcome, detail: int) -> None:
    transcript, chip = scripted(text)
    with transcript:
        assert chip.start() is outcome
        assert chip.detail == detail


def test_a_chip_that_lost_its_supply_is_found() -> None:
    transcript, chip = scripted("spi adxl 80 00 -> 00 e5\nspi adxl b1 00 -> 00 00")
    with transcript:
        assert chip.check() is Outcome.NOT_CONFIGURED


def test_nobody_on_i2c_is_a_result() -> None:
    transcript = Transcript("\n".join([
        "i2c bus 53 write 2d 00 -> address-nack", "i2c bus 53 write 31 0b -> address-nack",
        "i2c bus 53 write 00 read 1 -> address-nack", "i2c bus 53 write 32 read 6 -> address-nack",
        "i2c bus 53 write 39 read 1 -> timeout",
    ]))  # fmt: skip
    chip = Adxl345(I2cPort(ScriptedI2c(transcript, "bus")), ScriptedCpu(transcript), Adxl345Config())
    with transcript:
        assert chip.start() is Outcome.ABSENT
        assert chip.read() is False
        assert chip.read_fifo() == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate_hz": 150}, "rate_hz is 150; possible: 3200, 1600"),
        ({"rate_hz": True}, "rate_hz is True"),
        ({"range_g": 3}, "range_g is 3; possible: 2, 4, 8, 16"),
        ({"fifo": "trigger"}, "fifo is 'trigger'"),
        ({"watermark": 0}, "watermark is 0; possible: 1 to 31"),
        ({"watermark": 32}, "watermark is 32"),
        ({"interrupt_pin": 3}, "interrupt_pin is 3"),
        ({"offsets": (0, 0, 200)}, "offsets are"),
        ({"supply_v": 5.0}, "supply_v is 5.0; possible: 2.0 to 3.6"),
    ],
)
def test_settings_the_chip_does_not_have(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Adxl345Config(**change)


def test_address() -> None:
    with pytest.raises(ValueError, match="0x54; possible: 0x53, 0x1D"):
        I2cPort(ScriptedI2c(Transcript(""), "bus"), 0x54)


# -- against the chip model ------------------------------------------------------------------------


class World:
    """An ImuWorld of constant or growing force (g, and g per s)."""

    def __init__(self, force: tuple[float, ...] = (0.0, 0.0, 1.0), growth: float = 0.0) -> None:
        self.force, self.growth = np.array(force), growth

    def sample(self, times_ns: Any, bandwidth_hz: float) -> Any:
        values = np.zeros((len(times_ns), 7))
        values[:, :3] = self.force * G
        values[:, 0] += self.growth * times_ns * 1e-9 * G
        return values


class Board:
    """A processor with an SPI controller at 5 MHz and an I²C bus at 400 kHz."""

    def __init__(self) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "mcu", 168_000_000, [LineSpec("imu", 1)])
        self.spi = EmulatedSpiBus(self.cpu, SpiTiming(5_000_000))
        self.i2c = EmulatedI2cBus(self.cpu, 400_000)

    def on_spi(self, world: World, **options: Any) -> tuple[ChipModel, RegisterPort]:
        model = ChipModel(self.time, world, **options)
        return model, SpiPort(self.spi.device(model))

    def on_i2c(self, world: World, **options: Any) -> tuple[ChipModel, RegisterPort]:
        model = ChipModel(self.time, world, **options)
        self.i2c.attach(model.i2c.address, model.i2c)
        return model, I2cPort(self.i2c, model.i2c.address)


Place = Callable[..., tuple[ChipModel, RegisterPort]]
BUSES = pytest.mark.parametrize("place", [Board.on_spi, Board.on_i2c], ids=["spi", "i2c"])


@BUSES
def test_starts_and_reads(place: Place) -> None:
    board = Board()
    model, port = place(board, World((0.5, -0.25, 1.0)))
    chip = Adxl345(port, board.cpu, Adxl345Config(range_g=4))
    assert chip.start() is Outcome.OK
    assert chip.read()
    force = np.zeros(sample.FORCE_SIZE, np.float32)
    sample.convert(chip.raw, sample.scale(), force)
    assert force == pytest.approx(np.array([0.5, -0.25, 1.0]) * G, rel=1e-6)
    assert chip.check() is Outcome.OK
    assert model.reports == []


@BUSES
@pytest.mark.parametrize("rate_hz", [12.5, 100, 800])
def test_fifo_gives_every_sample_once(place: Place, rate_hz: float) -> None:
    board = Board()
    model, port = place(board, World(growth=rate_hz / 256.0), clock_error_ppm=-3000.0)
    chip = Adxl345(port, board.cpu, Adxl345Config(rate_hz=rate_hz, fifo="stream"))
    assert chip.start() is Outcome.OK
    got: list[int] = []
    for _ in range(30):
        board.cpu.delay(round(20e9 / rate_hz))
        count = chip.read_fifo()
        assert count < 32
        got += chip.fifo[:count, 1:3].copy().view("<i2")[:, 0].tolist()
    steps = np.diff(got)
    assert len(got) > 500
    assert set(steps.tolist()) <= {1, 2}  # the clock is 0.3 % slow
    assert model.reports == []


@BUSES
@pytest.mark.parametrize("supply_v", [2.0, 2.5, 3.3, 3.6])
def test_self_test(place: Place, supply_v: float) -> None:
    board = Board()
    _, port = place(board, World(), supply_v=supply_v)
    chip = Adxl345(port, board.cpu, Adxl345Config(supply_v=supply_v))
    assert chip.start() is Outcome.OK
    assert chip.self_test() is Outcome.OK
    assert chip.check() is Outcome.NOT_CONFIGURED
    assert chip.start() is Outcome.OK


def test_self_test_of_a_stuck_axis_fails() -> None:
    board = Board()
    _, port = board.on_spi(World())

    class Stuck:
        pop_wait_ns = port.pop_wait_ns
        read, write = port.read, port.write

        def sample(self, buffer: bytearray) -> bool:
            port.sample(buffer)
            buffer[3:5] = b"\x10\x00"
            return True

    chip = Adxl345(Stuck(), board.cpu, Adxl345Config())
    assert chip.start() is Outcome.OK
    assert chip.self_test() is Outcome.SELF_TEST_FAILED
    assert chip.detail == 1


@BUSES
def test_start_from_whatever_state(place: Place) -> None:
    board = Board()
    _, port = place(board, World())
    for register, value in (
        (0x31, 0xA7),
        (0x1F, 0x33),
        (0x38, 0xFF),
        (0x2E, 0x7F),
        (0x2A, 0x0F),
        (0x2D, 0x3F),
    ):
        assert port.write(register, value)
    board.cpu.delay(300 * MS)
    chip = Adxl345(port, board.cpu, Adxl345Config())
    assert chip.start() is Outcome.OK
    assert chip.read()
    assert chip.raw[1:].view("<i2").tolist() == [0, 0, 256]


@BUSES
def test_supply_dip_is_found_and_mended(place: Place) -> None:
    board = Board()
    model, port = place(board, World())
    chip = Adxl345(port, board.cpu, Adxl345Config())
    assert chip.start() is Outcome.OK
    model.brownout()
    assert chip.check() is Outcome.NOT_CONFIGURED
    assert chip.start() is Outcome.OK
    model.power(False)
    assert chip.check() is Outcome.ABSENT
    assert chip.start() is Outcome.ABSENT
    model.power(True)
    assert chip.start() is Outcome.OK


def test_several_chips_on_one_controller() -> None:
    board = Board()
    chips = []
    for k in range(3):
        _, port = board.on_spi(World((0.1 * k, 0.0, 1.0)))
        chips.append(Adxl345(port, board.cpu, Adxl345Config(rate_hz=200)))
    for chip in chips:
        assert chip.start() is Outcome.OK
    for k, chip in enumerate(chips):
        chip.read()
        assert chip.raw[1:3].view("<i2")[0] == round(25.6 * k)


@pytest.mark.parametrize("pin", [1, 2])
def test_data_ready_drives_the_reading(pin: int) -> None:
    board = Board()
    model, port = board.on_spi(World(growth=200 / 256.0), clock_error_ppm=1000.0)
    net = Net(board.time, "INT")
    model.pins[f"INT{pin}"] = net
    chip = Adxl345(port, board.cpu, Adxl345Config(rate_hz=200, interrupt_pin=pin))
    got: list[int] = []

    def on_data() -> None:
        chip.read()
        got.append(int(chip.raw[1:3].view("<i2")[0]))

    EmulatedInputPin(board.cpu, net).interrupt_on(Edge.RISING, board.cpu.attach("imu", on_data))
    assert chip.start() is Outcome.OK
    del got[:]
    events = board.time.events_run
    for _ in range(400):
        board.cpu.wait_for_interrupt()
    assert np.diff(got).tolist().count(1) >= 398
    assert board.time.events_run - events <= 405
    assert model.reports == []


def test_three_wires() -> None:
    board = Board()
    _, port = board.on_spi(World(), spi_wires=3)
    assert Adxl345(port, board.cpu, Adxl345Config()).start() is Outcome.ABSENT
    chip = Adxl345(port, board.cpu, Adxl345Config(three_wire=True))
    assert chip.start() is Outcome.OK
    assert chip.self_test() is Outcome.OK


def test_alternative_address() -> None:
    board = Board()
    board.on_i2c(World(), sdo_high=True)
    config = Adxl345Config()
    assert Adxl345(I2cPort(board.i2c, ALTERNATIVE_ADDRESS), board.cpu, config).start() is Outcome.OK
    assert Adxl345(I2cPort(board.i2c, ADDRESS), board.cpu, config).start() is Outcome.ABSENT


# -- conversion ------------------------------------------------------------------------------------


@given(some.tuples(*[some.integers(-32768, 32767)] * 3), some.floats(100.0, 400.0))
def test_conversion(counts: tuple[int, int, int], lsb_per_g: float) -> None:
    raw = np.frombuffer(b"\x00" + np.array(counts, "<i2").tobytes(), np.uint8)
    force = np.zeros(3, np.float32)
    sample.convert(raw.copy(), sample.scale(lsb_per_g), force)
    assert force == pytest.approx(np.array(counts) * G / lsb_per_g, rel=3e-7)
