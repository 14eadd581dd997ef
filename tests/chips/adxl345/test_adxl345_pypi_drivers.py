"""Drivers from PyPI, unmodified, on the chip's I²C face: their bus calls go to an emulated bus.

Each is skipped where it is not installed: adafruit-circuitpython-adxl34x and -adxl37x (with the maker's own
bus device library), micropython-adxl343. None of them speaks SPI.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import pytest
from adxl345_rig import MS, BenchWorld, G, Motion

from boards.chips.adxl345 import Adxl345
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.virtual_time import VirtualTime
from hal.errors import BusError


class Bench:
    """Processor, bus at 400 kHz and chip."""

    def __init__(self, motion: Motion, **options: Any) -> None:
        self.time = VirtualTime()
        self.cpu = EmulatedCpu(self.time, "host", 100_000_000)
        self.bus = EmulatedI2cBus(self.cpu, 400_000)
        self.world = BenchWorld(motion)
        self.chip = Adxl345(self.time, self.world, **options)
        self.bus.attach(self.chip.i2c.address, self.chip.i2c)

    def sleep(self, seconds: float) -> None:
        """time.sleep on virtual time."""
        self.cpu.delay(round(seconds * 1e9))


class BusioI2c:
    """busio.I2C as far as adafruit_bus_device uses it."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._locked = False

    def try_lock(self) -> bool:
        """Nobody else is there."""
        assert not self._locked
        self._locked = True
        return True

    def unlock(self) -> None:
        """The end of a `with`."""
        self._locked = False

    def _transaction(self, address: int, write: bytes, read: int = 0) -> bytes:
        assert self._locked
        try:
            return self._bench.bus.transaction(address, write, read)
        except BusError as error:
            raise OSError(str(error)) from None

    def writeto(self, address: int, buffer: bytes, *, start: int = 0, end: int | None = None) -> None:
        """One write with a stop."""
        self._transaction(address, bytes(buffer[start : len(buffer) if end is None else end]))

    def readfrom_into(
        self, address: int, buffer: bytearray, *, start: int = 0, end: int | None = None
    ) -> None:
        """One read."""
        end = len(buffer) if end is None else end
        buffer[start:end] = self._transaction(address, b"", end - start)


class MicropythonBus:
    """machine.I2C as far as the driver uses it."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench

    def readfrom_mem(self, address: int, register: int, length: int) -> bytes:
        """Register read."""
        return self._bench.bus.transaction(address, bytes((register,)), length)

    def writeto_mem(self, address: int, register: int, data: bytes) -> None:
        """Register write."""
        self._bench.bus.transaction(address, bytes((register,)) + data)


@pytest.fixture
def interpreter(monkeypatch: pytest.MonkeyPatch) -> None:
    """MicroPython's `const` as the identity."""
    module = ModuleType("micropython")
    module.const = lambda value: value  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "micropython", module)


def tilted(t: Any) -> dict[str, Any]:
    return {"fx": 0.5 * G + 0.0 * t, "fy": -0.25 * G, "fz": 0.75 * G}


def knocks(*times: float) -> Motion:
    """Rest, with knocks of 5 ms and 4 g on z."""
    return lambda t: {"fz": G + 4.0 * G * sum(((t >= when) & (t < when + 0.005)) * 1.0 for when in times)}


# -- adafruit-circuitpython-adxl34x --------------------------------------------------------------------


@pytest.fixture
def adxl34x(interpreter: None) -> Any:
    return pytest.importorskip("adafruit_adxl34x")


@pytest.mark.parametrize(("high", "address"), [(False, 0x53), (True, 0x1D)])
def test_adxl34x_starts_and_reads(adxl34x: Any, high: bool, address: int) -> None:
    bench = Bench(tilted, sdo_high=high)
    driver = adxl34x.ADXL345(BusioI2c(bench), address=address)
    bench.sleep(0.05)
    assert driver.acceleration == pytest.approx(tuple(f * 256 * 0.004 * G for f in (0.5, -0.25, 0.75)))
    assert (driver.raw_x, driver.raw_y, driver.raw_z) == (128, -64, 192)
    assert bench.chip.reports == []


def test_adxl34x_finds_nobody_at_another_address(adxl34x: Any) -> None:
    with pytest.raises(ValueError, match="No I2C device"):
        adxl34x.ADXL345(BusioI2c(Bench(tilted)), address=0x1D)


def test_adxl34x_rates_and_ranges(adxl34x: Any) -> None:
    bench = Bench(lambda t: {"fz": 7.0 * G})
    driver = adxl34x.ADXL345(BusioI2c(bench))
    assert driver.data_rate == adxl34x.DataRate.RATE_100_HZ
    assert driver.range == adxl34x.Range.RANGE_2_G
    for code, limit in ((0, 511), (1, 1023), (2, 1792), (3, 1792)):
        driver.range = code
        bench.sleep(0.02)
        assert driver.range == code
        assert driver.raw_z == limit
    for rate in range(16):
        driver.data_rate = rate
        assert driver.data_rate == rate
    assert bench.chip.reports == []


def test_adxl34x_offsets(adxl34x: Any) -> None:
    bench = Bench(tilted)
    driver = adxl34x.ADXL345(BusioI2c(bench))
    bench.sleep(0.05)
    raw = (driver.raw_x, driver.raw_y, driver.raw_z)
    driver.offset = tuple(round(-count / 4) for count in raw)
    assert driver.offset == (-32, 16, -48)
    bench.sleep(0.05)
    assert (driver.raw_x, driver.raw_y, driver.raw_z) == (0, 0, 0)


@pytest.mark.parametrize(("count", "times", "found"), [
    (1, [0.5], True), (1, [], False), (2, [0.5, 0.6], True), (2, [0.5], False),
])  # fmt: skip
def test_adxl34x_taps(adxl34x: Any, count: int, times: list[float], found: bool) -> None:
    bench = Bench(knocks(*times))
    driver = adxl34x.ADXL345(BusioI2c(bench))
    driver.enable_tap_detection(tap_count=count, threshold=40)
    bench.sleep(0.3)
    assert driver.events == {"tap": False}
    bench.sleep(1.0)
    assert driver.events == {"tap": found}
    assert driver.events == {"tap": False}
    driver.disable_tap_detection()
    assert bench.chip.reports == []


def test_adxl34x_motion_and_free_fall(adxl34x: Any) -> None:
    def motion(t: Any) -> dict[str, Any]:
        return {"fz": G * ~((t > 0.5) & (t < 0.8)), "fx": 3.0 * G * ((t > 1.5) & (t < 1.6))}

    bench = Bench(motion)
    driver = adxl34x.ADXL345(BusioI2c(bench))
    driver.enable_motion_detection(threshold=20)
    driver.enable_freefall_detection(threshold=8, time=25)
    bench.sleep(0.4)
    assert driver.events == {"motion": False, "freefall": False}
    bench.sleep(0.6)
    assert driver.events == {"motion": False, "freefall": True}
    bench.sleep(1.0)
    assert driver.events == {"motion": True, "freefall": False}
    driver.disable_motion_detection()
    driver.disable_freefall_detection()
    assert driver.events == {}


# -- adafruit-circuitpython-adxl37x: the same registers, and data ready -----------------------------------


def test_adxl37x_data_ready(interpreter: None) -> None:
    module = pytest.importorskip("adafruit_adxl37x")
    bench = Bench(tilted)
    driver = module.ADXL375(BusioI2c(bench))
    driver.enable_data_ready_interrupt()
    assert driver.events == {"data_ready": False}
    bench.sleep(0.012)
    assert driver.events == {"data_ready": True}
    assert driver.acceleration == pytest.approx(tuple(n * 0.049 * G for n in (128, -64, 192)))
    assert driver.events == {"data_ready": False}
    assert bench.chip.reports == []


# -- micropython-adxl343 -----------------------------------------------------------------------------------


@pytest.fixture
def adxl343(interpreter: None) -> Any:
    return pytest.importorskip("micropython_adxl343.adxl343")


def test_adxl343_starts_and_reads(adxl343: Any) -> None:
    bench = Bench(tilted)
    driver = adxl343.ADXL343(MicropythonBus(bench))
    bench.sleep(0.05)
    assert driver.measurement_mode == "READY"
    assert driver.acceleration == pytest.approx(tuple(n * G * 0.004 for n in (128, -64, 192)))
    driver.acceleration_range = adxl343.RANGE_16
    driver.resolution_mode = adxl343.LOW_RES
    bench.sleep(0.02)
    assert driver.acceleration == pytest.approx(tuple(n * G * 0.031 for n in (16, -8, 24)))
    driver.measurement_mode = adxl343.STANDBY
    assert driver.measurement_mode == "STANDBY"
    assert bench.chip.reports == []


def test_adxl343_double_tap(adxl343: Any) -> None:
    bench = Bench(knocks(0.5, 0.6))
    driver = adxl343.ADXL343(MicropythonBus(bench))
    driver.tap_threshold = 3.0 * G
    driver.tap_duration = 20_000
    driver.tap_latent = 50
    driver.tap_window = 100
    driver.double_tap_mode = adxl343.DT_ENABLED
    bench.sleep(0.55)
    assert not driver.double_tap_activated
    bench.sleep(0.2)
    assert driver.double_tap_activated
    assert not driver.double_tap_activated
    assert bench.chip.reports == []


def test_adxl343_activity(adxl343: Any) -> None:
    bench = Bench(lambda t: {"fx": 2.0 * G * (t > 1.0)})
    driver = adxl343.ADXL343(MicropythonBus(bench))
    driver.activity_threshold = 1.0 * G
    driver.activity_mode = adxl343.ACTIVITY_ENABLED
    bench.sleep(0.9)
    assert not driver.activity_detected
    bench.sleep(0.2)
    assert driver.activity_detected
    bench.sleep(1 * MS * 1e-9)
    assert bench.chip.reports == []
