"""What it costs to read a sample through driver, bus and chip model: processor time, best of several.

The world is trivial (constant), so that a figure is that of driver, bus and model; blocks of samples are
part of it. `together` reads seven chips on one controller at 200 Hz, the figure being that of one read.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from boards.chips.adis16407 import Adis16407 as Adis16407Model
from boards.chips.adxl345 import Adxl345 as Adxl345Model
from boards.chips.bmi160 import Bmi160 as Bmi160Model
from boards.chips.hmc6343 import Hmc6343 as Hmc6343Model
from firmware.drivers.adis16407 import Adis16407, Adis16407Config
from firmware.drivers.adxl345 import Adxl345, Adxl345Config, Outcome
from firmware.drivers.adxl345_ports import I2cPort, RegisterPort, SpiPort
from firmware.drivers.bmi160 import Bmi160, Bmi160Config
from firmware.drivers.hmc6343 import Hmc6343, Hmc6343Config
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import SECOND, VirtualTime

RATE_HZ = 200
SAMPLES = 4_000
CHIPS_TOGETHER = 7
MEGAHERTZ = 1_000_000


class Still:
    """A world at rest."""

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> NDArray[np.float64]:
        """See boards.chips.world.ImuWorld."""
        return np.tile([0.0, 0.0, 9.80665, 0.0, 0.0, 0.0, 25.0], (len(times_ns), 1))


class Bench:
    """A processor with ADXL345s on SPI at 5 MHz, or one on I²C at 400 kHz."""

    def __init__(self, count: int = 1, *, i2c: bool = False, fifo: str = "bypass") -> None:
        self.cpu = EmulatedCpu(VirtualTime(), "mcu", 168 * MEGAHERTZ)
        config = Adxl345Config(rate_hz=RATE_HZ, fifo=fifo)
        ports = [self._i2c_port()] if i2c else self._spi_ports(count)
        self.chips = [Adxl345(port, self.cpu, config) for port in ports]
        for chip in self.chips:
            if chip.start() is not Outcome.OK:
                raise RuntimeError("the ADXL345 of the benchmark does not start")

    def _spi_ports(self, count: int) -> list[RegisterPort]:
        bus = EmulatedSpiBus(self.cpu, SpiTiming(5 * MEGAHERTZ))
        return [SpiPort(bus.device(Adxl345Model(self.cpu.time, Still()), f"U{k}")) for k in range(count)]

    def _i2c_port(self) -> RegisterPort:
        bus = EmulatedI2cBus(self.cpu, 400_000)
        model = Adxl345Model(self.cpu.time, Still())
        bus.attach(model.i2c.address, model.i2c)
        return I2cPort(bus)

    def read_all(self) -> None:
        """Every chip once."""
        for chip in self.chips:
            chip.read()


class StillTenDof:
    """A world at rest with field and pressure."""

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> NDArray[np.float64]:
        """See boards.chips.world.TenDofWorld."""
        row = [0.0, 0.0, 9.80665, 0.0, 0.0, 0.0, 25.0, 2e-5, 0.0, 4e-5, 101_325.0]
        return np.tile(row, (len(times_ns), 1))


class StillCompass:
    """A world at rest with a field."""

    row = np.array([[0.0, 0.0, 9.80665, 2e-5, 0.0, 4e-5, 25.0]])

    def sample(self, times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """See boards.chips.world.CompassWorld."""
        return self.row.repeat(len(times_ns), axis=0)


class AdisBench:
    """An ADIS16407 on SPI at 1 MHz: a burst of 15 words."""

    def __init__(self) -> None:
        self.cpu = EmulatedCpu(VirtualTime(), "mcu", 168 * MEGAHERTZ)
        timing = SpiTiming(MEGAHERTZ, bits_per_word=16, stall_clocks=1, high_ns=9_000)
        device = EmulatedSpiBus(self.cpu, timing).device(Adis16407Model(self.cpu.time, StillTenDof()), "U1")
        self.chips = [Adis16407(device, self.cpu, Adis16407Config())]
        self.chips[0].start()

    def read_all(self) -> None:
        """One burst."""
        self.chips[0].read()


class BmiBench:
    """A BMI160 on SPI at 5 MHz: rate, force and sensortime, 15 bytes."""

    def __init__(self) -> None:
        self.cpu = EmulatedCpu(VirtualTime(), "mcu", 168 * MEGAHERTZ)
        model = Bmi160Model(self.cpu.time, Still())
        device = EmulatedSpiBus(self.cpu, SpiTiming(5 * MEGAHERTZ)).device(model, "U1")
        self.chips = [Bmi160(device, self.cpu, Bmi160Config(rate_hz=RATE_HZ))]
        self.chips[0].start()

    def read_all(self) -> None:
        """One burst."""
        self.chips[0].read()


class CompassBench:
    """An HMC6343 on I²C at 100 kHz: a command, its delay, its answer."""

    def __init__(self) -> None:
        self.cpu = EmulatedCpu(VirtualTime(), "mcu", 168 * MEGAHERTZ)
        bus = EmulatedI2cBus(self.cpu, 100_000)
        model = Hmc6343Model(self.cpu.time, StillCompass())
        bus.attach(model.address, model)
        self.chips = [Hmc6343(bus, self.cpu, Hmc6343Config(rate_hz=10))]
        self.chips[0].start()

    def read_all(self) -> None:
        """Heading, pitch and roll."""
        self.chips[0].read()


def read_us(repeats: int) -> dict[str, float]:
    """Microseconds of a read, each time of a new sample (of the compass at 10 Hz: of every twentieth), by
    way: six data bytes of the ADXL345, a burst of the ADIS16407 or BMI160, a heading of the HMC6343."""
    return {
        "adis16407_burst": _per_read(AdisBench(), repeats),
        "bmi160_burst": _per_read(BmiBench(), repeats),
        "hmc6343_heading": _per_read(CompassBench(), repeats),
        "adxl345_spi": _per_read(Bench(), repeats),
        "adxl345_spi_fifo": _per_read(Bench(fifo="stream"), repeats),
        "adxl345_spi_seven_together": _per_read(Bench(CHIPS_TOGETHER), repeats),
        "adxl345_i2c": _per_read(Bench(i2c=True), repeats),
    }


def _per_read(bench: Bench | AdisBench | BmiBench | CompassBench, repeats: int) -> float:
    """Reading once a sample, less the processor's wait alone."""
    pause = 168 * MEGAHERTZ // RATE_HZ

    def once_a_sample() -> None:
        bench.read_all()
        bench.cpu.spend(pause)

    reading = min(_seconds(once_a_sample) for _ in range(repeats))
    waiting = min(_seconds(lambda: bench.cpu.spend(pause)) for _ in range(repeats))
    return (reading - waiting) / SAMPLES / len(bench.chips) * SECOND / 1_000


def _seconds(work: Callable[[], None]) -> float:
    """Processor time of `work` for each sample."""
    begin = time.process_time()
    for _ in range(SAMPLES):
        work()
    return time.process_time() - begin
