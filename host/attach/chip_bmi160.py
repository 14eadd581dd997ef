"""The BMI160 on the desk.

Its sensortime tells which sample a burst holds: at a rate of r the data registers change whenever the
counter of 25.6 kHz passes a multiple of 25600 / r (fact sheet section 4), so samples that were missed or
read twice are known exactly, and so is the error of the chip's clock.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.bmi160 import CHIP_ID, Bmi160, Bmi160Config, Outcome
from firmware.drivers.bmi160_sample import BURST_LENGTH, SAMPLE_SIZE, SENSORTIME_MASK, convert
from hal.cpu import Cpu
from hal.errors import BusError
from hal.i2c import I2cBus
from hal.spi import SpiDevice
from host.attach.chip_on_desk import Found, Poll, Quantity

SENSORTIME_HZ = 25_600
POLLS_PER_SAMPLE = 1.3
"""A chip's clock may be a few per cent fast, and a poll some milliseconds late."""
DEGREES = 180.0 / np.pi
DATA = slice(1, 13)
"""In a burst; all zero while the sensors sleep, as after power-on, or the line is low."""
IDLE = 0xFF
READ = 0x80


class Bmi160OnDesk:
    """Implements `host.attach.chip_on_desk.ChipOnDesk`."""

    name = "bmi160"
    quantities = (
        *(Quantity(f"rate {axis}", "°/s", DEGREES) for axis in "xyz"),
        *(Quantity(f"force {axis}", "m/s²") for axis in "xyz"),
    )

    def __init__(self, device: SpiDevice, cpu: Cpu, rate_hz: int) -> None:
        config = Bmi160Config(rate_hz=rate_hz, data_ready_pin=False)
        self._chip = Bmi160(device, cpu, config)
        self._scale = config.scales()
        self._ticks_per_sample = SENSORTIME_HZ // rate_hz
        self._last: int | None = None
        """Sensortime of the last burst that held something new."""
        self._ticks: int | None = None
        """Since the first sample."""
        self._convert(np.zeros(BURST_LENGTH, np.uint8))  # so that it is compiled before time counts
        self.polls_per_s = POLLS_PER_SAMPLE * rate_hz

    def start(self) -> Found:
        """Reset, identify, set up and read back."""
        self._last = None
        return self._found(self._chip.start())

    def check(self) -> Found:
        """Chip id, power state, settings, error flags."""
        return self._found(self._chip.check())

    def poll(self) -> Poll:
        """One burst."""
        chip = self._chip
        chip.read()
        if not chip.raw[DATA].any() or (chip.raw[1:] == IDLE).all():
            return Poll(alive=False)
        sample, now = self._convert(chip.raw)
        if self._last is None:
            self._last = now  # what the registers hold may be of before the ranges were set
            return Poll()
        ticks = self._ticks_per_sample
        passed = ((now // ticks) - (self._last // ticks)) % ((SENSORTIME_MASK + 1) // ticks)
        if passed == 0:
            return Poll()
        since_last = (now - self._last) & SENSORTIME_MASK
        self._ticks = 0 if self._ticks is None else self._ticks + since_last
        self._last = now
        return Poll([sample], passed - 1)

    def temperature(self) -> float | None:
        """°C."""
        return self._chip.temperature()

    def clock_s(self) -> float | None:
        """By the sensortime."""
        return None if self._ticks is None else self._ticks / SENSORTIME_HZ

    def _convert(self, raw: NDArray[np.uint8]) -> tuple[NDArray[np.float32], int]:
        sample = np.empty(SAMPLE_SIZE, np.float32)
        return sample, int(convert(raw, self._scale, sample))

    def _found(self, outcome: Outcome) -> Found:
        read = f"0x{self._chip.detail:02X}"
        if outcome is Outcome.OK:
            return Found(True, f"chip id 0x{CHIP_ID:02X}")
        if outcome in (Outcome.ABSENT, Outcome.WRONG_CHIP):
            told = f"{outcome.value}: chip id reads {read}, a BMI160 has 0x{CHIP_ID:02X}"
            return Found(False, told, outcome is Outcome.ABSENT)
        return Found(False, f"{outcome.value}: {read} was read")


class RegistersOverI2c:
    """Implements `hal.spi.SpiDevice` on I²C, for a driver that knows SPI: register first, bit 7 = read.

    What nobody acknowledges reads as 0xFF, as on an SPI line without a slave.
    """

    def __init__(self, bus: I2cBus, address: int) -> None:
        self._bus = bus
        self._address = address

    def transaction(self, buffer: bytearray) -> None:
        """A read or write of registers."""
        register = buffer[0] & ~READ
        try:
            if buffer[0] & READ:
                buffer[1:] = self._bus.transaction(self._address, bytes((register,)), len(buffer) - 1)
            else:
                self._bus.transaction(self._address, bytes(buffer))
        except BusError:
            buffer[:] = b"\xff" * len(buffer)
