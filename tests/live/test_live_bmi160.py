"""The BMI160 driver as it is flashed, through the bridge's protocol to a chip, or to a record of one.

With NAVTWIN_BUS_PIRATE=/dev/ttyUSB0 (and a BMI160 wired as docs/live.md shows) the same body runs on the
chip on the desk, and writes the record that the third run reads.
"""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from bridged_chips import Desktop

from firmware.drivers.bmi160 import Bmi160, Bmi160Config, Outcome
from firmware.drivers.bmi160_sample import convert, nanoseconds_between
from hal.live.bus_pirate_buses import BusPirateSpi
from hal.live.cpu import LiveCpu
from hal.scripted import ScriptedCpu, ScriptedSpi, Transcript
from hal.scripted.recording import Recording

RECORD = Path(__file__).with_name("bmi160_desk.txt")
HARDWARE = os.environ.get("NAVTWIN_BUS_PIRATE")


class Bench(NamedTuple):
    spi: Any
    cpu: Any


@contextmanager
def recorded_to(path: Path, spi: Any, cpu: Any) -> Iterator[Bench]:
    """The record takes its place only when the test has passed."""
    draft = path.with_suffix(".draft")
    with draft.open("w") as file:
        recording = Recording(file)
        yield Bench(recording.spi("imu", spi), recording.cpu(cpu))
    draft.replace(path)


@pytest.fixture
def bench(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Bench]:
    if request.param == "hardware":
        if not HARDWARE:
            pytest.skip("no bridge: set NAVTWIN_BUS_PIRATE to its port to run on hardware")
        cpu = LiveCpu()
        spi = BusPirateSpi(cpu, HARDWARE)
        with recorded_to(RECORD, spi, cpu) as recording:
            yield recording
        spi.close()
    elif request.param == "emulated":
        with Desktop(tmp_path / "ttyBRIDGE") as desk:
            cpu = LiveCpu()
            spi = BusPirateSpi(cpu, desk.url)
            with recorded_to(tmp_path / "record.txt", spi, cpu) as recording:
                yield recording
            spi.close()
            assert not desk.chip.reports, desk.chip.reports
    else:
        with Transcript(RECORD.read_text()) as transcript:
            yield Bench(ScriptedSpi(transcript, "imu"), ScriptedCpu(transcript))


@pytest.mark.parametrize("bench", ["hardware", "emulated", "recorded"], indirect=True)
def test_a_chip_at_rest(bench: Bench) -> None:
    config = Bmi160Config(rate_hz=100, data_ready_pin=False)
    chip = Bmi160(bench.spi, bench.cpu, config)
    assert chip.start() is Outcome.OK
    assert chip.check() is Outcome.OK
    temperature = chip.temperature()
    assert temperature is not None
    assert 10.0 < temperature < 45.0

    scale = config.scales()
    samples, ticks = [], []
    for _ in range(20):
        bench.cpu.delay(10_000_000)
        chip.read()
        sample = np.zeros(6, np.float32)
        ticks.append(int(convert(chip.raw, scale, sample)))
        samples.append(sample)
    mean = np.mean(samples, axis=0)
    assert np.linalg.norm(mean[3:]) == pytest.approx(9.81, abs=0.4)  # 40 mg of zero-g offset, three axes
    assert np.abs(mean[:3]).max() < np.radians(5.0)  # 3 °/s of zero-rate offset
    elapsed = [nanoseconds_between(a, b) for a, b in pairwise(ticks)]
    assert min(elapsed) >= 10_000_000 * 0.98


def test_the_record_of_a_run_replays_it(tmp_path: Path) -> None:
    """Through the bridge, recorded; then from the record: the driver sees the same bytes."""
    path = tmp_path / "run.txt"

    def body(spi: Any, cpu: Any) -> list[bytes]:
        chip = Bmi160(spi, cpu, Bmi160Config(rate_hz=200))
        assert chip.start() is Outcome.OK
        bursts = []
        for _ in range(5):
            cpu.delay(5_000_000)
            chip.read()
            bursts.append(chip.raw.tobytes())
        return bursts

    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        cpu = LiveCpu()
        spi = BusPirateSpi(cpu, desk.url)
        with path.open("w") as file:
            recording = Recording(file)
            seen = body(recording.spi("imu", spi), recording.cpu(cpu))
        spi.close()
    assert len(set(seen)) > 1
    with Transcript(path.read_text()) as transcript:
        assert body(ScriptedSpi(transcript, "imu"), ScriptedCpu(transcript)) == seen


def test_what_crosses_the_bus_is_what_the_driver_says(tmp_path: Path) -> None:
    """The bridge's own log of chip select periods against the data sheet's set-up sequence."""
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        cpu = LiveCpu()
        spi = BusPirateSpi(cpu, desk.url, speed_hz=4_000_000)
        chip = Bmi160(spi, cpu, Bmi160Config())
        assert chip.start() is Outcome.OK
        assert desk.pirate.speed_hz == 4_000_000
        assert desk.pirate.spi_config == 0b1010  # 3.3 V outputs, idle low, active to idle: SPI mode 0
        spi.close()
        sent = [mosi.hex() for mosi, _ in desk.pirate.transfers]
        assert sent[:4] == ["ff00", "7eb6", "ff00", "8000"]
        assert desk.pirate.transfers[3][1][1] == 0xD1
        assert not desk.pirate.power


def test_a_chip_that_loses_power_with_the_bridge_is_started_again(tmp_path: Path) -> None:
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        cpu = LiveCpu()
        spi = BusPirateSpi(cpu, desk.url)
        chip = Bmi160(spi, cpu, Bmi160Config())
        assert chip.start() is Outcome.OK
        desk.port.send(desk.pirate.reset())
        assert chip.check() is Outcome.ABSENT  # 0xFF: the line floats
        deadline = time.monotonic() + 5.0
        while (outcome := chip.check()) is Outcome.ABSENT and time.monotonic() < deadline:
            cpu.delay(20_000_000)
        assert outcome in (Outcome.NOT_STARTED, Outcome.WRONG_CHIP)  # back, in its power-on state
        assert chip.start() is Outcome.OK
        assert spi.session.counters.recoveries == 1
        spi.close()
