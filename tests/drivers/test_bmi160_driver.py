"""The BMI160 driver: transaction by transaction as the fact sheet wants it, and on the chip model's bus."""

import math
import timeit

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from boards.chips.bmi160 import Bmi160 as ChipModel
from firmware.drivers import bmi160_sample as sample
from firmware.drivers.bmi160 import Bmi160, Bmi160Config, Outcome
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.faults import SpiMissingChip
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import VirtualTime
from hal.scripted.cpu import ScriptedCpu
from hal.scripted.spi import ScriptedSpi
from hal.scripted.transcript import Transcript

WAKE = """
delay 10000000
spi imu ff 00 -> 00 00          # dummy read: SPI from now on
spi imu 7e b6 -> 00 00          # soft reset
delay 2000000
spi imu ff 00 -> 00 00          # dummy read again
spi imu 80 00 -> 00 {chip_id}   # CHIP_ID
"""
POWER = """
spi imu 7e 11 -> 00 00          # accelerometer normal
delay 5000000
spi imu 7e 15 -> 00 00          # gyroscope normal
delay 85000000
spi imu 83 00 -> 00 {power}     # PMU_STATUS
"""
CONFIGURE = """
spi imu 40 28 -> 00 00          # ACC_CONF: normal filter, 100 Hz
delay 2000
spi imu 41 05 -> 00 00          # ACC_RANGE 4 g
delay 2000
spi imu 42 28 -> 00 00          # GYR_CONF
delay 2000
spi imu 43 03 -> 00 00          # GYR_RANGE 250 deg/s
delay 2000
spi imu 53 0a -> 00 00          # INT1 output, push-pull, active high
delay 2000
spi imu 54 00 -> 00 00          # not latched
delay 2000
spi imu 56 80 -> 00 00          # data ready to INT1
delay 2000
spi imu 51 10 -> 00 00          # data ready enabled
delay 2000
"""
READ_BACK = """
spi imu c0 00 -> 00 28
spi imu c1 00 -> 00 05
spi imu c2 00 -> 00 28
spi imu c3 00 -> 00 {gyro_range}
"""
REST_OF_READ_BACK = """
spi imu d3 00 -> 00 0a
spi imu d4 00 -> 00 00
spi imu d6 00 -> 00 80
spi imu d1 00 -> 00 10
spi imu 82 00 -> 00 {errors}    # ERR_REG
"""

AWAKE = WAKE.format(chip_id="d1")
POWERED = AWAKE + POWER.format(power="14") + CONFIGURE
HELD = POWERED + READ_BACK.format(gyro_range="03")


def scripted(text: str, config: Bmi160Config | None = None) -> tuple[Transcript, Bmi160]:
    transcript = Transcript(text)
    device = ScriptedSpi(transcript, "imu")
    return transcript, Bmi160(device, ScriptedCpu(transcript), config or Bmi160Config())


@pytest.mark.parametrize(
    ("text", "outcome", "detail"),
    [
        (WAKE.format(chip_id="ff"), Outcome.ABSENT, 0xFF),
        (WAKE.format(chip_id="00"), Outcome.ABSENT, 0x00),
        (WAKE.format(chip_id="d2"), Outcome.WRONG_CHIP, 0xD2),
        (AWAKE + POWER.format(power="10"), Outcome.NOT_STARTED, 0x10),
        (POWERED + READ_BACK.format(gyro_range="00"), Outcome.NOT_CONFIGURED, 0x00),
        (HELD + REST_OF_READ_BACK.format(errors="02"), Outcome.ERROR_FLAG, 0x02),
        (HELD + REST_OF_READ_BACK.format(errors="00"), Outcome.OK, 0x00),
    ],
)
def test_start(text, outcome, detail):
    transcript, chip = scripted(text)
    with transcript:
        assert chip.start() is outcome
        assert chip.detail == detail


def test_read_is_one_burst():
    burst = "8c" + " 00" * 15
    answer = "00 01 02 03 04 05 06 07 08 09 0a 0b 0c 0d 0e 0f"
    transcript, chip = scripted(f"spi imu {burst} -> {answer}\nspi imu {burst} -> {answer}")
    with transcript:
        chip.read()
        raw = chip.raw
        chip.read()
        assert raw is chip.raw
        assert raw.tolist() == list(range(16))


@pytest.mark.parametrize(
    ("text", "outcome", "detail"),
    [
        ("spi imu 80 00 -> 00 00", Outcome.ABSENT, 0x00),
        ("spi imu 80 00 -> 00 31", Outcome.WRONG_CHIP, 0x31),
        ("spi imu 80 00 -> 00 d1\nspi imu 82 00 00 -> 00 00 00", Outcome.NOT_STARTED, 0x00),
        (
            "spi imu 80 00 -> 00 d1\nspi imu 82 00 00 -> 00 00 14\nspi imu c0 00 00 00 00 -> 00 28 03 28 03",
            Outcome.NOT_CONFIGURED,
            0x03,
        ),
        (
            "spi imu 80 00 -> 00 d1\nspi imu 82 00 00 -> 00 01 14\nspi imu c0 00 00 00 00 -> 00 28 05 28 03",
            Outcome.ERROR_FLAG,
            0x01,
        ),
        (
            "spi imu 80 00 -> 00 d1\nspi imu 82 00 00 -> 00 00 14\nspi imu c0 00 00 00 00 -> 00 28 05 28 03",
            Outcome.OK,
            0x00,
        ),
    ],
)
def test_check(text, outcome, detail):
    transcript, chip = scripted(text)
    with transcript:
        assert chip.check() is outcome
        assert chip.detail == detail


def test_data_that_stay_zero_are_a_chip_that_was_reset():
    burst = "spi imu 8c" + " 00" * 15 + " -> 00" + " 00" * 12 + " 10 20 00"
    transcript, chip = scripted(burst + "\nspi imu 80 00 -> 00 d1\nspi imu 82 00 00 -> 00 00 14")
    with transcript:
        chip.read()
        assert chip.check() is Outcome.NOT_STARTED


@pytest.mark.parametrize(
    ("bytes_read", "expected"), [("00 00", 23.0), ("00 02", 24.0), ("00 fe", 22.0), ("00 80", None)]
)
def test_temperature(bytes_read, expected):
    transcript, chip = scripted(f"spi imu a0 00 00 -> 00 {bytes_read}")
    with transcript:
        assert chip.temperature() == expected


SELF_TEST = """
spi imu 40 2c -> 00 00
delay 2000
spi imu 41 08 -> 00 00
delay 2000
spi imu 6d 0d -> 00 00
delay 50000000
spi imu 92 00 00 00 00 00 00 -> 00 00 f0 00 f0 00 f0
spi imu 6d 09 -> 00 00
delay 50000000
spi imu 92 00 00 00 00 00 00 -> 00 {x} 01 10 01 10
spi imu 6d 10 -> 00 00
delay 20000000
spi imu 9b 00 -> 00 {status}
"""


@pytest.mark.parametrize(
    ("x", "status", "outcome"),
    [
        ("01 10", "02", Outcome.OK),
        ("00 10", "02", Outcome.SELF_TEST_FAILED),
        ("01 10", "00", Outcome.SELF_TEST_FAILED),
    ],
)
def test_self_test(x, status, outcome):
    transcript, chip = scripted(SELF_TEST.format(x=x, status=status))
    with transcript:
        assert chip.self_test() is outcome


def test_other_settings():
    config = Bmi160Config(400, "osr2", False, 2000, 16, 15)
    expected = {0x40: 0x1A, 0x41: 0x0C, 0x42: 0x1A, 0x43: 0, 0x53: 0, 0x54: 0x0F, 0x56: 0, 0x51: 0}
    assert dict(config.registers()) == expected


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rate_hz": 60}, "BMI160 rate_hz is 60; possible: 25, 50, 100"),
        ({"bandwidth": "wide"}, "BMI160 bandwidth is 'wide'; possible: 'osr4', 'osr2', 'normal'"),
        ({"gyro_range_dps": 300}, "BMI160 gyro_range_dps is 300; possible: 2000"),
        ({"accel_range_g": 3}, "BMI160 accel_range_g is 3; possible: 2, 4, 8, 16"),
        ({"latch": 16}, "BMI160 latch is 16; possible: 0, 1"),
    ],
)
def test_settings_that_the_chip_does_not_have(changes, message):
    with pytest.raises(ValueError, match=message):
        Bmi160Config(**changes)


# -- conversion -------------------------------------------------------------------------------------


def burst(counts: list[int], ticks: int) -> np.ndarray:
    data = b"\0" + b"".join(count.to_bytes(2, "little", signed=True) for count in counts)
    return np.frombuffer(bytearray(data + ticks.to_bytes(3, "little")), np.uint8)


@settings(max_examples=100, deadline=None)
@given(
    some.lists(some.integers(-32768, 32767), min_size=6, max_size=6),
    some.integers(0, 2**24 - 1),
    some.integers(0, 2**23),
    some.sampled_from([(2000, 2), (1000, 4), (500, 8), (250, 16), (125, 2)]),
)
def test_conversion_against_float64(counts, before, passed, ranges):
    gyro_range, accel_range = ranges
    out = np.zeros(sample.SAMPLE_SIZE, np.float32)
    now = (before + passed) % 2**24
    assert sample.convert(burst(counts, now), sample.scales(gyro_range, accel_range), out) == now
    assert sample.nanoseconds_between(before, now) == passed * 390625 // 10
    # full scale is 32768 counts for the accelerometer, 32800 for the gyroscope (16.4 LSB per °/s)
    rate = math.radians(gyro_range) / 32800.0
    force = accel_range * 9.80665 / 32768.0
    expected = [c * rate for c in counts[:3]] + [c * force for c in counts[3:]]
    assert out == pytest.approx(expected, rel=2e-7, abs=0)


def test_default_conversion_is_that_of_the_default_settings():
    config = Bmi160Config()
    scale = sample.scales(config.gyro_range_dps, config.accel_range_g)
    assert scale.tolist() == [sample.RAD_PER_LSB, sample.METRE_PER_S2_PER_LSB]
    assert scale.tolist() == config.scales().tolist()


# -- on the chip model's bus ------------------------------------------------------------------------


class Turntable:
    """Turning at 10 °/s about z, chip level."""

    def sample(self, times_ns, bandwidth_hz):
        values = np.zeros((len(times_ns), 7))
        values[:, 2] = 9.80665
        values[:, 5] = math.radians(10.0)
        values[:, 6] = 31.5
        return values


class Bench:
    def __init__(self, config: Bmi160Config | None = None) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "mcu", 168_000_000)
        self.chip = ChipModel(self.time, Turntable())
        bus = EmulatedSpiBus(self.cpu, SpiTiming(5_250_000))
        self.device = bus.device(self.chip, "imu")
        self.driver = Bmi160(self.device, self.cpu, config or Bmi160Config())


@pytest.mark.parametrize("config", [Bmi160Config(), Bmi160Config(200, "osr4", True, 500, 2)])
def test_samples_through_register_model(config):
    bench = Bench(config)
    assert bench.driver.start() is Outcome.OK
    bench.cpu.delay(50_000_000)
    out = np.zeros(sample.SAMPLE_SIZE, np.float32)
    bench.driver.read()
    before = sample.convert(bench.driver.raw, config.scales(), out)
    bench.cpu.delay(10_000_000)
    bench.driver.read()
    now = sample.convert(bench.driver.raw, config.scales(), out)
    assert sample.nanoseconds_between(before, now) == pytest.approx(10_000_000, abs=100_000)
    half = [0.51 * float(unit) for unit in config.scales()]
    assert out[sample.OMEGA : sample.OMEGA + 3] == pytest.approx([0, 0, math.radians(10)], abs=half[0])
    assert out[sample.FORCE : sample.FORCE + 3] == pytest.approx([0, 0, 9.80665], abs=half[1])
    assert bench.driver.check() is Outcome.OK
    assert bench.driver.temperature() == pytest.approx(31.5, abs=0.01)
    assert bench.chip.reports == []


def test_a_reset_in_flight_is_noticed_and_repaired():
    bench = Bench()
    bench.driver.start()
    bench.cpu.delay(50_000_000)
    bench.driver.read()
    assert bench.driver.check() is Outcome.OK
    bench.chip.power(False)
    bench.cpu.delay(1_000_000)
    assert bench.driver.check() is Outcome.ABSENT
    bench.chip.power(True)
    bench.cpu.delay(20_000_000)
    bench.driver.read()
    assert bench.driver.check() is not Outcome.OK
    assert bench.driver.start() is Outcome.OK
    bench.cpu.delay(50_000_000)
    bench.driver.read()
    assert bench.driver.check() is Outcome.OK


def test_the_chip_models_self_test_passes():
    bench = Bench()
    bench.driver.start()
    assert bench.driver.self_test() is Outcome.OK
    assert bench.driver.start() is Outcome.OK


def test_bus_faults_are_outcomes():
    bench = Bench()
    missing = SpiMissingChip(0)
    missing.install(bench.device)
    assert bench.driver.start() is Outcome.ABSENT
    assert missing.fired > 0


def test_read_costs_little_python():
    class Wire:
        def transaction(self, buffer):
            pass

    wire = Wire()
    driver = Bmi160(wire, None, Bmi160Config())
    buffer = bytearray(16)
    n = 20_000
    # a busy machine is slower for everybody: 0.05 µs is what the bare call takes on a quiet one
    call = min(timeit.repeat(lambda: wire.transaction(buffer), number=n, repeat=7)) / n
    read = min(timeit.repeat(driver.read, number=n, repeat=7)) / n
    slowness = max(1.0, call / 0.05e-6)
    assert read - call < 0.3e-6 * slowness
