"""BMI160 over SPI: identify, configure, read. One attempt a call; not-ready is a result, never an exception.

Register and command facts: fact sheet sections 1 to 5 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.bmi160_sample import BURST_LENGTH
from hal.cpu import Cpu
from hal.spi import SpiDevice

CHIP_ID = 0xD1
READ = 0x80
FIRST_SAMPLE_REGISTER = 0x0C

RESET_NS = 2_000_000
"""Soft reset takes 1 ms (section 2); the same again as margin."""
ACCEL_START_NS = 5_000_000
"""3.8 ms (section 2)."""
GYRO_START_NS = 85_000_000
"""80 ms (section 2)."""
SUSPEND_WRITE_NS = 450_000
"""Between writes while both sensors are suspended (section 1)."""
NORMAL_WRITE_NS = 2_000


class Register(IntEnum):
    """Addresses that the driver uses."""

    CHIP_ID = 0x00
    ERR_REG = 0x02
    PMU_STATUS = 0x03
    TEMPERATURE = 0x20
    ACC_CONF = 0x40
    ACC_RANGE = 0x41
    GYR_CONF = 0x42
    GYR_RANGE = 0x43
    INT_EN_1 = 0x51
    INT_OUT_CTRL = 0x53
    INT_LATCH = 0x54
    INT_MAP_1 = 0x56
    CMD = 0x7E
    INTERFACE = 0x7F


class Command(IntEnum):
    """Commands written to CMD."""

    ACCEL_NORMAL = 0x11
    GYRO_NORMAL = 0x15
    SOFT_RESET = 0xB6


class Outcome(Enum):
    """What a call found."""

    OK = "ok"
    ABSENT = "nobody answers"
    WRONG_CHIP = "wrong chip id"
    NOT_STARTED = "a sensor did not reach normal mode"
    NOT_CONFIGURED = "a register does not hold what was written"
    ERROR_FLAG = "the chip reports an error"


ODR_CODES = {25: 0x6, 50: 0x7, 100: 0x8, 200: 0x9, 400: 0xA, 800: 0xB, 1600: 0xC}
BANDWIDTH_CODES = {"osr4": 0, "osr2": 1, "normal": 2}
BOTH_NORMAL = 0x14
PMU_MASK = 0x3C


@dataclass(frozen=True)
class Bmi160Config:
    """What is set up; ranges are fixed at ±250 °/s and ±4 g, to which `bmi160_sample` converts."""

    rate_hz: int = 100
    bandwidth: str = "normal"
    data_ready_pin: bool = True

    def registers(self) -> tuple[tuple[Register, int], ...]:
        """The writes, in order."""
        odr = ODR_CODES[self.rate_hz]
        bandwidth = BANDWIDTH_CODES[self.bandwidth]
        return (
            (Register.ACC_CONF, bandwidth << 4 | odr),
            (Register.ACC_RANGE, 0x05),
            (Register.GYR_CONF, bandwidth << 4 | odr),
            (Register.GYR_RANGE, 0x03),
            (
                Register.INT_OUT_CTRL,
                0x0A if self.data_ready_pin else 0x00,
            ),  # INT1 out, push-pull, active high
            (Register.INT_LATCH, 0x00),  # a pulse for each sample
            (Register.INT_MAP_1, 0x80 if self.data_ready_pin else 0x00),  # data ready to INT1
            (Register.INT_EN_1, 0x10 if self.data_ready_pin else 0x00),
        )


class Bmi160:
    """One chip. `raw` is the last burst as `bmi160_sample` wants it."""

    def __init__(self, spi: SpiDevice, cpu: Cpu, config: Bmi160Config) -> None:
        self.config = config
        self.detail = 0
        """The byte that made the last call fail."""
        self._spi = spi
        self._cpu = cpu
        self._burst = bytearray(BURST_LENGTH)
        self._request = bytes([READ | FIRST_SAMPLE_REGISTER]) + bytes(BURST_LENGTH - 1)
        self._transaction = spi.transaction
        self.raw: NDArray[np.uint8] = np.frombuffer(self._burst, np.uint8)

    def identify(self) -> Outcome:
        """Wake the SPI interface and ask who is there."""
        self._read(Register.INTERFACE)
        self.detail = self._read(Register.CHIP_ID)
        if self.detail == CHIP_ID:
            return Outcome.OK
        return Outcome.ABSENT if self.detail in (0x00, 0xFF) else Outcome.WRONG_CHIP

    def start(self) -> Outcome:
        """Soft reset, identify, both sensors to normal mode, configure, read back."""
        self._read(Register.INTERFACE)
        self._write(Register.CMD, Command.SOFT_RESET, RESET_NS)
        found = self.identify()
        if found is not Outcome.OK:
            return found
        self._write(Register.CMD, Command.ACCEL_NORMAL, ACCEL_START_NS)
        self._write(Register.CMD, Command.GYRO_NORMAL, GYRO_START_NS)
        self.detail = self._read(Register.PMU_STATUS)
        if self.detail & PMU_MASK != BOTH_NORMAL:
            return Outcome.NOT_STARTED
        for register, value in self.config.registers():
            self._write(register, value, NORMAL_WRITE_NS)
        for register, value in self.config.registers():
            self.detail = self._read(register)
            if self.detail != value:
                return Outcome.NOT_CONFIGURED
        return Outcome.OK

    def read(self) -> None:
        """Gyro, accelerometer and sensortime in one burst into `raw`."""
        burst = self._burst
        burst[:] = self._request
        self._transaction(burst)

    def check(self) -> Outcome:
        """Is it still the chip that was set up: identity, power mode, error flags (for the background)."""
        self.detail = self._read(Register.CHIP_ID)
        if self.detail != CHIP_ID:
            return Outcome.ABSENT if self.detail in (0x00, 0xFF) else Outcome.WRONG_CHIP
        self.detail = self._read(Register.PMU_STATUS)
        if self.detail & PMU_MASK != BOTH_NORMAL:
            return Outcome.NOT_STARTED
        self.detail = self._read(Register.ACC_RANGE)
        if self.detail != 0x05:
            return Outcome.NOT_CONFIGURED
        self.detail = self._read(Register.ERR_REG)
        return Outcome.ERROR_FLAG if self.detail else Outcome.OK

    def temperature(self) -> float | None:
        """°C; None while the chip has no valid value."""
        buffer = bytearray([READ | Register.TEMPERATURE, 0, 0])
        self._spi.transaction(buffer)
        value = int.from_bytes(buffer[1:3], "little", signed=True)
        return None if value == -0x8000 else 23.0 + value / 512.0

    def _read(self, register: Register) -> int:
        buffer = bytearray([READ | register, 0])
        self._spi.transaction(buffer)
        return buffer[1]

    def _write(self, register: Register, value: int, wait_ns: int) -> None:
        self._spi.transaction(bytearray([register, value]))
        self._cpu.delay(wait_ns)
