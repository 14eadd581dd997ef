"""The ADIS16407 driver: transaction by transaction as the sheet wants it, and on the chip model's bus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firmware.drivers import adis16407_sample as sample
from firmware.drivers.adis16407 import Adis16407, Adis16407Config, Alarm, Outcome
from hal.emulated.spi import SpiTiming
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
