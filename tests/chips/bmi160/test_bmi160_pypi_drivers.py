"""Drivers from PyPI, unmodified, on the chip's I²C face: their bus calls go to an emulated bus.

Each is skipped where it is not installed: BMI160-i2c (with smbus2), micropython-bmi160, circuitpython-bmi160.
"""

from __future__ import annotations

import sys
from math import radians
from types import ModuleType
from typing import Any

import pytest
from bmi160_rig import MS, BenchWorld, G

from boards.chips.bmi160 import Bmi160
from boards.chips.registers import ReportKind
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.virtual_time import VirtualTime


class I2cBench:
    """Processor, bus at 400 kHz and chip."""

    def __init__(self, motion: Any, **options: Any) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "host", 100_000_000)
        self.bus = EmulatedI2cBus(self.cpu, 400_000)
        self.world = BenchWorld(motion)
        self.chip = Bmi160(self.time, self.world, **options)
        self.bus.attach(self.chip.i2c.address, self.chip.i2c)
        self.cpu.delay(10 * MS)

    def sleep(self, seconds: float) -> None:
        """time.sleep on virtual time."""
        self.cpu.delay(round(seconds * 1e9))

    @property
    def unexpected(self) -> list[str]:
        """Reports other than writes that follow too fast."""
        return [str(report) for report in self.chip.reports if report.kind is not ReportKind.TIMING]


def tumbling(t: Any) -> dict[str, Any]:
    return {
        "fx": 0.25 * G,
        "fz": -G,
        "wx": radians(100.0),
        "wy": radians(-20.0),
        "temperature": 30.0 + 0.0 * t,
    }


class SmbusAdapter:
    """The part of smbus2.SMBus that the driver uses."""

    def __init__(self, bench: I2cBench) -> None:
        self._bench = bench

    def i2c_rdwr(self, *messages: Any) -> None:
        """Plain writes, and a write with a read behind a repeated start."""
        write = bytes(list(messages[0]))
        read = messages[1] if len(messages) > 1 else None
        data = self._bench.bus.transaction(messages[0].addr, write, read.len if read is not None else 0)
        for i, byte in enumerate(data):
            read.buf[i] = bytes((byte,))

    def close(self) -> None:
        """Nothing to close."""


@pytest.fixture
def bmi160_i2c(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, I2cBench]:
    """(driver, bench) of BMI160-i2c."""
    pytest.importorskip("smbus2")
    package = pytest.importorskip("BMI160_i2c")
    bench = I2cBench(tumbling)
    monkeypatch.setattr(package, "SMBus", lambda _number: SmbusAdapter(bench))
    monkeypatch.setattr(package.sleep, "sleep", bench.sleep)
    return package.Driver(0x68), bench


def test_bmi160_i2c_starts_and_reads(bmi160_i2c: tuple[Any, I2cBench]) -> None:
    driver, bench = bmi160_i2c
    assert driver.get_device_id() == 0xD1
    bench.sleep(0.05)
    gx, gy, gz, ax, ay, az = driver.getMotion6()
    assert (gx, gy, gz) == (round(100 * 131.2), round(-20 * 131.2), 0)
    assert (ax, ay, az) == (4096, 0, -16384)
    assert driver.getTemperature() == pytest.approx(30.0, abs=0.01)
    assert bench.unexpected == []


def test_bmi160_i2c_rates_and_ranges(bmi160_i2c: tuple[Any, I2cBench]) -> None:
    driver, bench = bmi160_i2c
    driver.set_gyro_rate(11)
    driver.setFullScaleAccelRange(0x08, 8.0)
    driver.setFullScaleGyroRange(0, 2000.0)
    assert driver.get_gyro_rate() == 11
    assert (driver.getFullScaleAccelRange(), driver.getFullScaleGyroRange()) == (0x08, 0)
    bench.sleep(0.01)
    assert driver.getRotation()[0] == 1640
    assert driver.getAcceleration() == (1024, 0, -4096)


def test_bmi160_i2c_calibrates(bmi160_i2c: tuple[Any, I2cBench]) -> None:
    driver, bench = bmi160_i2c
    driver.autoCalibrateXAccelOffset(0)
    assert driver.getXAccelOffset() == -64 & 0xFF
    driver.setAccelOffsetEnabled(True)
    assert driver.getAccelOffsetEnabled()
    bench.sleep(0.02)
    assert driver.getAccelerationX() == (0,)


def test_bmi160_i2c_any_motion_latched(bmi160_i2c: tuple[Any, I2cBench]) -> None:
    driver, bench = bmi160_i2c
    driver.setRegister(0x60, 10)
    driver.setRegister(0x50, 0x07)
    driver.setInterruptLatch(15)
    driver.setIntEnabled(True)
    bench.sleep(0.1)
    assert driver.getIntStatus0() == 0
    bench.world.motion = lambda t: {"fx": G * (t % 0.02 > 0.01)}
    bench.sleep(2.0)
    assert driver.getIntStatus0() == 0x04
    driver.resetInterrupt()
    assert bench.unexpected == []


class MicropythonBus:
    """machine.I2C as far as the driver uses it."""

    def __init__(self, bench: I2cBench) -> None:
        self._bench = bench

    def readfrom_mem(self, address: int, register: int, length: int) -> bytes:
        """Register read."""
        return self._bench.bus.transaction(address, bytes((register,)), length)

    def writeto_mem(self, address: int, register: int, data: bytes) -> None:
        """Register write."""
        self._bench.bus.transaction(address, bytes((register,)) + data)


@pytest.fixture
def micropython_bmi160(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any, I2cBench]:
    """(module, driver, bench) of micropython-bmi160, with MicroPython's `const` as the identity."""
    interpreter = ModuleType("micropython")
    interpreter.const = lambda value: value  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "micropython", interpreter)
    module = pytest.importorskip("micropython_bmi160.bmi160")
    bench = I2cBench(tumbling, sdo_high=True)
    monkeypatch.setattr(module.time, "sleep", bench.sleep)
    return module, module.BMI160(MicropythonBus(bench)), bench


def test_micropython_driver_starts_and_reads(micropython_bmi160: tuple[Any, Any, I2cBench]) -> None:
    _, driver, bench = micropython_bmi160
    bench.sleep(0.05)
    assert (driver._acc_data_x, driver._acc_data_y, driver._acc_data_z) == (4096, 0, -16384)
    assert driver.temperature == pytest.approx(30.0, abs=0.05)
    assert driver._power_mode == 0x14
    assert driver._error_code == 0
    assert bench.unexpected == []


def test_micropython_driver_sets_rates_and_modes(micropython_bmi160: tuple[Any, Any, I2cBench]) -> None:
    module, driver, bench = micropython_bmi160
    driver.acceleration_output_data_rate = module.BANDWIDTH_400
    driver.gyro_output_data_rate = module.BANDWIDTH_200
    assert (driver._acc_config, driver._gyro_config) == (0x2A, 0x29)
    driver.acceleration_range = module.ACCEL_RANGE_8G
    bench.sleep(0.01)
    assert driver._acc_data_z == -4096
    driver.gyro_power_mode = module.GYRO_POWER_SUSPEND
    assert driver._power_mode == 0x10
    assert driver.gyro_power_mode == "GYRO_POWER_SUSPEND"


class BusioI2c:
    """busio.I2C as far as adafruit_bus_device uses it."""

    def __init__(self, bench: I2cBench) -> None:
        self._bench = bench

    def try_lock(self) -> bool:
        """Nobody else is there."""
        return True

    def unlock(self) -> None:
        """The end of a `with`."""

    def writeto(self, address: int, buffer: bytes, *, start: int = 0, end: int | None = None) -> None:
        """One write with a stop."""
        self._bench.bus.transaction(address, bytes(buffer[start : len(buffer) if end is None else end]))

    def writeto_then_readfrom(
        self,
        address: int,
        out_buffer: bytes,
        in_buffer: bytearray,
        *,
        out_start: int = 0,
        out_end: int | None = None,
        in_start: int = 0,
        in_end: int | None = None,
    ) -> None:
        """A write, and a read behind a repeated start."""
        end = len(in_buffer) if in_end is None else in_end
        write = bytes(out_buffer[out_start : len(out_buffer) if out_end is None else out_end])
        in_buffer[in_start:end] = self._bench.bus.transaction(address, write, end - in_start)


@pytest.fixture
def circuitpython_bmi160(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any, I2cBench]:
    """(module, driver, bench) of circuitpython-bmi160."""
    interpreter = ModuleType("micropython")
    interpreter.const = lambda value: value  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "micropython", interpreter)
    pytest.importorskip("adafruit_bus_device")
    pytest.importorskip("adafruit_register")
    module = pytest.importorskip("bmi160")
    bench = I2cBench(tumbling, sdo_high=True)
    monkeypatch.setattr(module.time, "sleep", bench.sleep)
    return module, module.BMI160(BusioI2c(bench)), bench


def test_circuitpython_driver_starts_and_reads(circuitpython_bmi160: tuple[Any, Any, I2cBench]) -> None:
    module, driver, bench = circuitpython_bmi160
    bench.sleep(0.05)
    assert (driver._acc_data_x, driver._acc_data_y, driver._acc_data_z) == (4096, 0, -16384)
    assert driver.temperature == pytest.approx(30.0, abs=0.05)
    assert (driver._device_id, driver._power_mode, driver._error_code) == (0xD1, 0x14, 0)
    driver.acceleration_range = module.ACCEL_RANGE_16G
    driver.gyro_range = module.GYRO_RANGE_500
    bench.sleep(0.05)
    assert (driver.acceleration_range, driver._acc_data_z) == ("ACCEL_RANGE_16G", -2048)
    assert driver._gyro_data_x == round(100 * 65.6)
    assert bench.unexpected == []
