"""The ADIS16407 driver: transaction by transaction as the sheet wants it, and on the chip model's bus."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from boards.chips.adis16407 import Adis16407 as ChipModel
from firmware.drivers import adis16407_sample as sample
from firmware.drivers.adis16407 import Adis16407, Adis16407Config, Alarm, Outcome
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import VirtualTime
from hal.scripted.cpu import ScriptedCpu
from hal.scripted.spi import ScriptedSpi
from hal.scripted.transcript import Transcript

G = 9.80665
MS = 1_000_000
GOLDEN = Path(__file__).parents[1] / "chips" / "adis16407" / "adis16407_golden.txt"
TIMING = SpiTiming(1_000_000, bits_per_word=16, stall_clocks=1, high_ns=9_000)


# -- against written transcripts -------------------------------------------------------------------


def scripted(text: str, config: Adis16407Config | None = None) -> tuple[Transcript, Adis16407]:
    transcript = Transcript(text)
    chip = Adis16407(ScriptedSpi(transcript, "imu"), ScriptedCpu(transcript), config or Adis16407Config())
    return transcript, chip


def test_driver_asks_the_golden_transcript() -> None:
    """The one that the model answers in tests/chips/adis16407."""
    config = Adis16407Config(alarms=(Alarm("gyro_x", 48),), alarm_pin=2)
    transcript, chip = scripted(GOLDEN.read_text(), config)
    values = np.zeros(sample.SAMPLE_SIZE, np.float32)
    cpu = chip._cpu
    with transcript:
        assert chip.start() is Outcome.OK
        rates, flags = [], []
        for _ in range(3):
            chip.read()
            flags.append(sample.convert(chip.raw, config.scales(), values))
            rates.append(float(np.degrees(values[0])))
            cpu.delay(20 * MS)
        assert rates == pytest.approx([2.2, 2.4, 2.6], abs=1e-5)
        assert flags == [sample.NEW, sample.NEW, sample.NEW | sample.ERROR]
        assert np.degrees(values[1:3]) == pytest.approx([-0.05, 300.0], abs=1e-4)
        assert values[3:6] == pytest.approx([-G, 0.0, G], abs=1e-5)
        assert values[6:9] == pytest.approx([0.2e-4, -0.1e-4, 0.45e-4], abs=1e-9)
        assert values[9] == np.float32(100_000.09375)
        assert values[10:] == pytest.approx([35.064, 2068 * 2.418e-3, 0.0], abs=1e-4)
        assert (chip.check(), chip.detail) == (Outcome.ALARM, 0x0100)
        cpu.delay(3 * MS)
        chip.read()
        assert sample.flags(chip.raw) == sample.NEW | sample.ERROR
        chip.read()
        assert sample.flags(chip.raw) == sample.ERROR
        cpu.delay(100 * MS)
        chip.read()
        assert chip.check() is Outcome.ALARM
        assert chip.self_test() is Outcome.OK
        assert chip.null_gyros() is Outcome.OK
        assert chip.save() is Outcome.OK
        chip.read()


START = "delay 220000000\nspi imu c2 80 -> 00 00\ndelay 220000000\nspi imu 56 00 -> 00 00\n"


@pytest.mark.parametrize(
    ("answer", "outcome", "detail"),
    [
        ("ff ff", Outcome.ABSENT, 0xFFFF),
        ("00 00", Outcome.ABSENT, 0x0000),
        ("40 15", Outcome.WRONG_CHIP, 0x4015),
        ("41 07", Outcome.WRONG_CHIP, 0x4107),
    ],
)
def test_start_tells_who_answers(answer: str, outcome: Outcome, detail: int) -> None:
    transcript, chip = scripted(START + f"spi imu 00 00 -> {answer}")
    with transcript:
        assert (chip.start(), chip.detail) == (outcome, detail)


IDENTITY = "spi imu 56 00 -> 00 00\nspi imu 00 00 -> 40 17\n"


def look(*answers: tuple[str, str]) -> str:
    return IDENTITY + "\n".join(f"spi imu {a} 00 -> 00 00\nspi imu 00 00 -> {v}" for a, v in answers)


HELD = (
    ("3c", "04 02"), ("3a", "00 01"), ("44", "00 00"), ("46", "00 00"), ("48", "00 00"), ("4a", "00 00"),
    ("4c", "00 00"), ("38", "00 06"),
)  # fmt: skip


@pytest.mark.parametrize(
    ("text", "outcome"),
    [
        (look(*HELD, ("40", "00 00")), Outcome.OK),
        (look(*HELD, ("40", "01 00")), Outcome.ALARM),
        (look(*HELD, ("40", "01 10")), Outcome.ERROR_FLAG),
        (look(("3c", "01 02")), Outcome.NOT_CONFIGURED),
        (look(*HELD[:7], ("38", "00 00")), Outcome.NOT_CONFIGURED),
    ],
)
def test_check(text: str, outcome: Outcome) -> None:
    transcript, chip = scripted(text)
    with transcript:
        assert chip.check() is outcome


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"period": 0}, "period is 0; possible: 1 to 128"),
        ({"period": True}, "period is True"),
        ({"gyro_range_dps": 250}, "gyro_range_dps is 250; possible: 300, 150, 75"),
        ({"filter": 7}, "filter is 7; possible: 0 to 6"),
        ({"data_ready_pin": 3}, "data_ready_pin is 3; possible: 1, 2, None"),
        ({"alarm_pin": 1}, "alarm_pin is 1, the pin of data ready"),
        ({"alarms": (Alarm("baro", 0),) * 3}, "3 alarms; possible: at most 2"),
    ],
)
def test_settings_the_part_does_not_have(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Adis16407Config(**change)


def test_alarms_the_part_does_not_have() -> None:
    with pytest.raises(ValueError, match="alarm source is 'yaw'; possible: 'supply', 'gyro_x'"):
        Alarm("yaw", 0)
    with pytest.raises(ValueError, match="alarm samples is 256"):
        Alarm("gyro_x", 0, samples=256)


# -- conversion ------------------------------------------------------------------------------------


@given(some.binary(min_size=30, max_size=30), some.sampled_from([300, 150, 75]))
def test_conversion_of_any_burst(burst: bytes, dps: int) -> None:
    """Against the sheet's scales in plain arithmetic."""
    words = [int.from_bytes(burst[k : k + 2], "big") for k in range(2, 30, 2)]
    signed = [(w & 0x3FFF) - (0x4000 if w & 0x2000 else 0) for w in words]
    celsius = (words[12] & 0xFFF) - (0x1000 if words[12] & 0x800 else 0)
    values = np.zeros(sample.SAMPLE_SIZE, np.float32)
    raw = np.frombuffer(bytearray(burst), np.uint8)
    flags = sample.convert(raw, Adis16407Config(gyro_range_dps=dps).scales(), values)
    assert np.degrees(values[:3].astype(float)) == pytest.approx(
        [c * 0.05 * dps / 300.0 for c in signed[1:4]], rel=1e-6
    )
    assert values[3:6] == pytest.approx([c * G / 300.0 for c in signed[4:7]], rel=1e-6)
    assert values[6:9] == pytest.approx([c * 0.5e-7 for c in signed[7:10]], rel=1e-6)
    assert values[9] == ((words[10] & 0x3FFF) * 256 + (words[11] & 0xFF)) * 0.03125
    assert values[10] == pytest.approx(25.0 + celsius * 0.136, rel=1e-6, abs=1e-5)
    assert values[11] == pytest.approx((words[0] & 0xFFF) * 2.418e-3, rel=1e-6)
    assert values[12] == pytest.approx((words[13] & 0xFFF) * 0.806e-3, rel=1e-6)
    assert bool(flags & sample.NEW) == all(w & 0x8000 for w in words)
    assert bool(flags & sample.ERROR) == any(w & 0x4000 for w in words)


# -- against the chip model ------------------------------------------------------------------------


class World:
    """A TenDofWorld that turns at a constant rate in °/s."""

    def __init__(self, rate: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        self.rate = np.radians(rate)

    def sample(self, times_ns: Any, _bandwidth_hz: float) -> Any:
        still = [0.0, 0.0, G, *self.rate, 25.0, 2e-5, 0.0, 4e-5, 101_325.0]
        return np.tile(still, (len(times_ns), 1))


class Bench:
    """Processor, bus, chip, driver. The model is strict."""

    def __init__(
        self, config: Adis16407Config | None = None, world: World | None = None, **options: Any
    ) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "mcu", 168_000_000, [])
        self.model = ChipModel(self.time, world or World(), strict=True, **options)
        self.spi = EmulatedSpiBus(self.cpu, TIMING).device(self.model, "imu")
        self.config = config or Adis16407Config()
        self.chip = Adis16407(self.spi, self.cpu, self.config)

    def rates(self) -> Any:
        values = np.zeros(sample.SAMPLE_SIZE, np.float32)
        self.cpu.delay(10 * MS)
        self.chip.read()
        sample.convert(self.chip.raw, self.config.scales(), values)
        return np.degrees(values[:3])


@pytest.mark.parametrize("dps", [300, 150, 75])
def test_every_range_gives_the_same_rate(dps: int) -> None:
    bench = Bench(Adis16407Config(gyro_range_dps=dps, period=4, filter=1), World((50.0, -60.0, 0.5)))
    assert bench.chip.start() is Outcome.OK
    assert bench.rates() == pytest.approx([50.0, -60.0, 0.5], abs=1e-4)


@pytest.mark.parametrize("precise", [False, True])
def test_gyros_are_nulled_and_stay_so(precise: bool) -> None:
    bench = Bench(world=World((2.0, -3.0, 0.1)))
    assert bench.chip.start() is Outcome.OK
    assert bench.chip.null_gyros(precise) is Outcome.OK
    assert bench.rates() == pytest.approx([0.0, 0.0, 0.0], abs=0.01)
    bench.model.brownout()
    bench.cpu.delay(300 * MS)
    assert bench.chip.start() is Outcome.OK
    assert bench.rates() == pytest.approx([0.0, 0.0, 0.0], abs=0.01)


def test_a_reset_behind_the_drivers_back_is_found() -> None:
    bench = Bench(Adis16407Config(period=8))
    assert bench.chip.start() is Outcome.OK
    bench.model.brownout()
    bench.cpu.delay(300 * MS)
    assert (bench.chip.check(), bench.chip.detail) == (Outcome.NOT_CONFIGURED, 0x0001)
    assert bench.chip.start() is Outcome.OK
    bench.model.power(False)
    assert bench.chip.check() is Outcome.ABSENT


def test_what_the_chip_reports_reaches_the_driver() -> None:
    bench = Bench(defects=["gyro_y"])
    assert bench.chip.start() is Outcome.OK
    assert (bench.chip.self_test(), bench.chip.detail) == (Outcome.SELF_TEST_FAILED, 0x0820)
    bench.model.break_parts()
    assert bench.chip.self_test() is Outcome.OK
    bench.model.supply_v = 4.6
    bench.cpu.delay(5 * MS)
    assert (bench.chip.check(), bench.chip.detail) == (Outcome.ERROR_FLAG, 0x0001)
    assert bench.chip.save() is Outcome.NOT_SAVED
    bench.model.supply_v = 5.0
    bench.cpu.delay(5 * MS)
    bench.chip.check()
    assert bench.chip.save() is Outcome.OK


def test_a_burst_between_request_and_answer_does_no_harm() -> None:
    """As an interrupt would: after every first word of the background."""
    bench = Bench()
    assert bench.chip.start() is Outcome.OK
    inner = bench.spi
    words = 0

    class Interrupted:
        def transaction(self, buffer: bytearray) -> None:
            nonlocal words
            inner.transaction(buffer)
            words += len(buffer) == 2
            if len(buffer) == 2 and words % 5 == 1:
                bench.chip.read()

    bench.chip._spi = Interrupted()
    for _ in range(5):
        assert bench.chip.check() is Outcome.OK
