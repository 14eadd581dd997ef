"""Our filter fed through an emulated chip: the recording moves the chip, our driver reads its registers.

bmi160      ±2000 °/s, ±16 g, 400 samples/s on SPI at 5 MHz; it has no magnetometer: the recorded field is
            handed to the filter directly, the newest sample at each time
adis16407   ±300 °/s, 819.2 samples/s without its filter, bursts on SPI at 1 MHz; its own magnetometer,
            ±2.5 gauss

The chip is powered and started while the recording's first sample stands still, then read once a sample.
Attitudes are brought to the recording's own times by interpolation between the chip's samples.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Final

import numpy as np
from numpy.typing import NDArray

from boards.chips.adis16407 import Adis16407 as Adis16407Model
from boards.chips.bmi160 import Bmi160 as Bmi160Model
from firmware.drivers import adis16407_sample, bmi160_sample
from firmware.drivers.adis16407 import Adis16407, Adis16407Config
from firmware.drivers.adis16407 import Outcome as AdisOutcome
from firmware.drivers.bmi160 import Bmi160, Bmi160Config, Outcome
from firmware.nav.drift import layout as at
from firmware.nav.drift.settings import DriftSettings
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import VirtualTime
from host.attitude.estimates import TESLA_PER_MICROTESLA, Estimate, run_filter
from host.attitude.recorded_motion import RecordedMotion
from host.attitude.recording import AttitudeRecording, Floats
from host.attitude.scoring import east_north_up

CHIPS: Final = ("bmi160", "adis16407")
SECOND = 1_000_000_000
START_NS = SECOND
"""When the recording begins to move; the chips have started by then."""
CLOCK_HZ = 150_000_000

BMI160_CONFIG = Bmi160Config(rate_hz=400, gyro_range_dps=2000, accel_range_g=16, data_ready_pin=False)
BMI160_RANGE_DPS = 2000.0
BMI160_PERIOD_NS = Fraction(2_500_000)
BMI160_TIMING = SpiTiming(5_000_000)
ADIS16407_CONFIG = Adis16407Config(period=2, filter=0, data_ready_pin=None)
ADIS16407_RANGE_DPS = 300.0
ADIS16407_PERIOD_NS = Fraction(10 * SECOND, 8192)
AFTER_SAMPLE_NS = 300_000
"""A sample is read so long after it was taken."""
ADIS16407_TIMING = SpiTiming(1_000_000, bits_per_word=16, stall_clocks=1, high_ns=9_000)

Read = Callable[[float], Floats]
"""Reads the chip's newest sample, taken at a time of the recording (s): ω, f, m in SI units (9,)."""


def by_register_feed(chip: str, recording: AttitudeRecording, settings: DriftSettings) -> Estimate:
    """Our filter on what `chip`, one of CHIPS, tells of the recording. Its range is set here.

    RuntimeError when the driver does not find the chip as it should be.
    """
    benches = {"bmi160": _on_bmi160, "adis16407": _on_adis16407}
    range_dps = BMI160_RANGE_DPS if chip == "bmi160" else ADIS16407_RANGE_DPS
    times, rows = benches[chip](recording)
    settings = replace(settings, rate_range=math.radians(range_dps))
    quaternions, flags = run_filter(np.column_stack((np.diff(times, prepend=0.0), rows)), settings)
    wanted = recording.times
    saturated = _since_last(times, (flags & at.SATURATED) != 0, wanted)
    return Estimate(at_times(times, east_north_up(quaternions), wanted), saturated, len(rows))


def at_times(times: Floats, quaternions: Floats, wanted: Floats) -> Floats:
    """Attitudes (n, 4) at `times` interpolated to others, the nearest one outside."""
    after = np.clip(np.searchsorted(times, wanted), 1, len(times) - 1)
    before = after - 1
    share = np.clip((wanted - times[before]) / (times[after] - times[before]), 0.0, 1.0)[:, None]
    first, second = quaternions[before], quaternions[after]
    second = second * np.where(np.sum(first * second, axis=1) < 0.0, -1.0, 1.0)[:, None]
    mixed = first + share * (second - first)
    return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True), np.float64)


def _since_last(times: Floats, flagged: NDArray[np.bool_], wanted: Floats) -> NDArray[np.bool_]:
    """Whether anything was flagged since the wanted time before."""
    counts = np.concatenate(([0], np.cumsum(flagged)))[np.searchsorted(times, wanted, "right")]
    return np.asarray(np.diff(counts, prepend=0) > 0)


def _on_bmi160(recording: AttitudeRecording) -> tuple[Floats, Floats]:
    time = VirtualTime()
    cpu = EmulatedCpu(time, "mcu", CLOCK_HZ, [])
    model = Bmi160Model(time, RecordedMotion(recording, START_NS, ten_dof=False))
    driver = Bmi160(EmulatedSpiBus(cpu, BMI160_TIMING).device(model, "imu"), cpu, BMI160_CONFIG)
    outcome = driver.start()
    if outcome is not Outcome.OK:
        raise RuntimeError(f"BMI160 does not start: {outcome.value}")
    scale = BMI160_CONFIG.scales()
    sample = np.zeros(bmi160_sample.SAMPLE_SIZE, np.float32)
    field = recording.field * TESLA_PER_MICROTESLA

    def read(taken: float) -> Floats:
        driver.read()
        bmi160_sample.convert(driver.raw, scale, sample)
        newest = min(max(int(taken * recording.rate_hz + 1e-6), 0), len(field) - 1)
        return np.concatenate((sample, field[newest]))

    # Samples are taken at multiples of the period on the chip's clock, which runs since power-on.
    first_ns = math.ceil(START_NS / BMI160_PERIOD_NS) * BMI160_PERIOD_NS
    return _read_all(recording, cpu, read, first_ns, BMI160_PERIOD_NS)


def _on_adis16407(recording: AttitudeRecording) -> tuple[Floats, Floats]:
    time = VirtualTime()
    cpu = EmulatedCpu(time, "mcu", CLOCK_HZ, [])
    model = Adis16407Model(time, RecordedMotion(recording, START_NS, ten_dof=True))
    driver = Adis16407(EmulatedSpiBus(cpu, ADIS16407_TIMING).device(model, "imu"), cpu, ADIS16407_CONFIG)
    outcome = driver.start()
    if outcome is not AdisOutcome.OK:
        raise RuntimeError(f"ADIS16407 does not start: {outcome.value}")
    scale = ADIS16407_CONFIG.scales()
    sample = np.zeros(adis16407_sample.SAMPLE_SIZE, np.float32)

    def read(_taken: float) -> Floats:
        driver.read()
        adis16407_sample.convert(driver.raw, scale, sample)
        return sample[:9].astype(np.float64)

    cpu.wait_until(START_NS)
    driver.read()
    looked_ns = time.now
    driver.read()
    while not adis16407_sample.flags(driver.raw) & adis16407_sample.NEW:
        looked_ns = time.now
        driver.read()
    # The sample came while the burst before this one was on the wire.
    first_ns = looked_ns - (time.now - looked_ns) // 2
    return _read_all(recording, cpu, read, Fraction(first_ns), ADIS16407_PERIOD_NS)


def _read_all(
    recording: AttitudeRecording, cpu: EmulatedCpu, read: Read, first_ns: Fraction, period_ns: Fraction
) -> tuple[Floats, Floats]:
    """Times of all samples (s of the recording) and what was read of them (n, 9)."""
    count = int((len(recording) - 1) * recording.interval * SECOND / period_ns) + 1
    rows = np.empty((count, 9))
    up, down = period_ns.as_integer_ratio()
    first = math.ceil(first_ns)
    times = (np.arange(count) * float(period_ns) + float(first_ns - START_NS)) / SECOND
    for k in range(count):
        cpu.wait_until(first + k * up // down + AFTER_SAMPLE_NS)
        rows[k] = read(times[k])
    return times, rows
