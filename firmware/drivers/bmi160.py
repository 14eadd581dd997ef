"""BMI160 over SPI: identify, configure, read. One attempt a call; not-ready is a result, never an exception.

    start       reset, identify, both sensors to normal mode, configure, read everything back
    read        one burst: gyro, accelerometer, sensortime (the interrupt's call)
    check       still there, still awake, still configured? (the background's call)
    self_test   the chip's own test, `start` afterwards

Whoever gets another outcome than OK from `check` calls `start` again: a chip that was reset is in suspend
mode, its data registers hold zeros and its settings are those of power-on (fact sheet sections 2 and 3).
Registers and commands: sections 1 to 5 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.bmi160_sample import (
    BURST_LENGTH,
    DEFAULT_ACCEL_RANGE_G,
    DEFAULT_GYRO_RANGE_DPS,
    scales,
)
from hal.cpu import Cpu
from hal.machine_code import mypyc_attr
from hal.spi import SpiDevice

CHIP_ID: Final = 0xD1
READ: Final = 0x80
FIRST_SAMPLE_REGISTER: Final = 0x0C
NOBODY: Final = (0x00, 0xFF)
"""What a line without a chip reads as."""

POWER_ON_NS: Final = 10_000_000
"""From the supply to the first access (section 2)."""
RESET_NS: Final = 2_000_000
"""Soft reset takes 1 ms (section 2); the same again as margin."""
ACCEL_START_NS: Final = 5_000_000
"""3.8 ms; 5 ms is what Bosch waits (section 2)."""
GYRO_START_NS: Final = 85_000_000
"""80 ms (section 2)."""
WRITE_NS: Final = 2_000
"""Between writes in normal mode (section 1); after a command in suspend mode the times above are longer."""
ACCEL_TEST_NS: Final = 50_000_000
GYRO_TEST_NS: Final = 20_000_000
"""From the excitation to its result (section 5)."""


class Register(IntEnum):
    """Addresses that the driver uses."""

    CHIP_ID = 0x00
    ERR_REG = 0x02
    PMU_STATUS = 0x03
    ACC_X_L = 0x12
    STATUS = 0x1B
    TEMPERATURE = 0x20
    ACC_CONF = 0x40
    ACC_RANGE = 0x41
    GYR_CONF = 0x42
    GYR_RANGE = 0x43
    INT_EN_1 = 0x51
    INT_OUT_CTRL = 0x53
    INT_LATCH = 0x54
    INT_MAP_1 = 0x56
    SELF_TEST = 0x6D
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
    NOT_STARTED = "a sensor is not in normal mode"
    NOT_CONFIGURED = "a register does not hold what was written"
    ERROR_FLAG = "the chip reports an error"
    SELF_TEST_FAILED = "the self-test failed"


ODR_CODES: Final = {25: 0x6, 50: 0x7, 100: 0x8, 200: 0x9, 400: 0xA, 800: 0xB, 1600: 0xC}
BANDWIDTH_CODES: Final = {"osr4": 0, "osr2": 1, "normal": 2}
GYRO_RANGE_CODES: Final = {2000: 0, 1000: 1, 500: 2, 250: 3, 125: 4}
ACCEL_RANGE_CODES: Final = {2: 0x3, 4: 0x5, 8: 0x8, 16: 0xC}
HIGHEST_LATCH_CODE: Final = 15

BOTH_NORMAL: Final = 0x14
PMU_MASK: Final = 0x3C
INT1_PUSH_PULL_ACTIVE_HIGH: Final = 0x0A
DATA_READY_TO_INT1: Final = 0x80
DATA_READY_ENABLE: Final = 0x10
DATA_INVALID: Final = -0x8000
NO_DATA: Final = bytes(12)
CHECKED: Final = 4
"""Of the registers that are written, so many from ACC_CONF on are looked at again and again."""

TEST_ACC_CONF: Final = 0x2C
TEST_ACC_RANGE: Final = 0x08
TEST_POSITIVE: Final = 0x0D
TEST_NEGATIVE: Final = 0x09
TEST_GYRO: Final = 0x10
TEST_DIFFERENCE: Final = 8192
"""2 g at the 8 g range, between the two excitations, on every axis (section 5)."""
GYRO_TEST_OK: Final = 0x02


@dataclass(frozen=True)
class Bmi160Config:
    """What is set up. Raises ValueError for what the chip cannot do.

    Both sensors share rate and filter. `bmi160_sample.rate_and_force` converts at the default ranges,
    `bmi160_sample.convert` at any. `latch`: INT_LATCH code, 0 a pulse for each sample, 15 until read.
    """

    rate_hz: int = 100
    bandwidth: str = "normal"
    data_ready_pin: bool = True
    gyro_range_dps: int = DEFAULT_GYRO_RANGE_DPS
    accel_range_g: int = DEFAULT_ACCEL_RANGE_G
    latch: int = 0

    def __post_init__(self) -> None:
        _one_of("rate_hz", self.rate_hz, ODR_CODES)
        _one_of("bandwidth", self.bandwidth, BANDWIDTH_CODES)
        _one_of("gyro_range_dps", self.gyro_range_dps, GYRO_RANGE_CODES)
        _one_of("accel_range_g", self.accel_range_g, ACCEL_RANGE_CODES)
        _one_of("latch", self.latch, range(HIGHEST_LATCH_CODE + 1))

    def registers(self) -> tuple[tuple[Register, int], ...]:
        """The writes, in order."""
        filtered = BANDWIDTH_CODES[self.bandwidth] << 4 | ODR_CODES[self.rate_hz]
        pin = self.data_ready_pin
        return (
            (Register.ACC_CONF, filtered),
            (Register.ACC_RANGE, ACCEL_RANGE_CODES[self.accel_range_g]),
            (Register.GYR_CONF, filtered),
            (Register.GYR_RANGE, GYRO_RANGE_CODES[self.gyro_range_dps]),
            (Register.INT_OUT_CTRL, INT1_PUSH_PULL_ACTIVE_HIGH if pin else 0x00),
            (Register.INT_LATCH, self.latch),
            (Register.INT_MAP_1, DATA_READY_TO_INT1 if pin else 0x00),
            (Register.INT_EN_1, DATA_READY_ENABLE if pin else 0x00),
        )

    def scales(self) -> NDArray[np.float32]:
        """For `bmi160_sample.convert`."""
        return scales(self.gyro_range_dps, self.accel_range_g)


@mypyc_attr(allow_interpreted_subclasses=True)
class Bmi160:
    """One chip. `raw` is the last burst as `bmi160_sample` wants it."""

    def __init__(self, spi: SpiDevice, cpu: Cpu, config: Bmi160Config) -> None:
        self.config = config
        self.detail = 0
        """The byte that made the last call fail."""
        self._cpu = cpu
        self._burst = bytearray(BURST_LENGTH)
        self._request = bytearray([READ | FIRST_SAMPLE_REGISTER]) + bytes(BURST_LENGTH - 1)
        self._spi = spi
        self._held = bytes(value for _, value in config.registers()[:CHECKED])
        self.raw: NDArray[np.uint8] = np.frombuffer(self._burst, np.uint8)

    def identify(self) -> Outcome:
        """Wake the SPI interface and ask who is there."""
        self._read(Register.INTERFACE)
        self.detail = self._read(Register.CHIP_ID)
        if self.detail == CHIP_ID:
            return Outcome.OK
        return Outcome.ABSENT if self.detail in NOBODY else Outcome.WRONG_CHIP

    def start(self) -> Outcome:
        """Bring the chip up from whatever state it is in; takes 102 ms."""
        self._cpu.delay(POWER_ON_NS)
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
            self._write(register, value, WRITE_NS)
        for register, value in self.config.registers():
            self.detail = self._read(register)
            if self.detail != value:
                return Outcome.NOT_CONFIGURED
        self.detail = self._read(Register.ERR_REG)
        return Outcome.ERROR_FLAG if self.detail else Outcome.OK

    def read(self) -> None:
        """Gyro, accelerometer and sensortime in one burst into `raw`."""
        burst = self._burst
        burst[:] = self._request
        self._spi.transaction(burst)

    def check(self) -> Outcome:
        """Is it still the chip that was set up, awake, without error flags, and are its data alive?"""
        self.detail = self._read(Register.CHIP_ID)
        if self.detail != CHIP_ID:
            return Outcome.ABSENT if self.detail in NOBODY else Outcome.WRONG_CHIP
        errors, power = self._read_some(Register.ERR_REG, 2)
        self.detail = power
        dead = self._burst[1:13] == NO_DATA and any(self._burst[13:])
        if dead or power & PMU_MASK != BOTH_NORMAL:
            return Outcome.NOT_STARTED
        held = self._read_some(Register.ACC_CONF, CHECKED)
        if held != self._held:
            self.detail = next(byte for byte, value in zip(held, self._held, strict=True) if byte != value)
            return Outcome.NOT_CONFIGURED
        self.detail = errors
        return Outcome.ERROR_FLAG if errors else Outcome.OK

    def self_test(self) -> Outcome:
        """Deflect both sensors from within; takes 120 ms, and `start` is needed afterwards. At rest only."""
        self._write(Register.ACC_CONF, TEST_ACC_CONF, WRITE_NS)
        self._write(Register.ACC_RANGE, TEST_ACC_RANGE, WRITE_NS)
        self._write(Register.SELF_TEST, TEST_POSITIVE, ACCEL_TEST_NS)
        positive = self._acceleration()
        self._write(Register.SELF_TEST, TEST_NEGATIVE, ACCEL_TEST_NS)
        negative = self._acceleration()
        self._write(Register.SELF_TEST, TEST_GYRO, GYRO_TEST_NS)
        self.detail = self._read(Register.STATUS)
        # Sources disagree on the sign of the two excitations, not on what lies between them.
        deflected = all(abs(a - b) > TEST_DIFFERENCE for a, b in zip(positive, negative, strict=True))
        return Outcome.OK if deflected and self.detail & GYRO_TEST_OK else Outcome.SELF_TEST_FAILED

    def temperature(self) -> float | None:
        """°C; None while the chip has no valid value."""
        value = int.from_bytes(self._read_some(Register.TEMPERATURE, 2), "little", signed=True)
        return None if value == DATA_INVALID else 23.0 + value / 512.0

    def _acceleration(self) -> tuple[int, ...]:
        data = self._read_some(Register.ACC_X_L, 6)
        return tuple(int.from_bytes(data[k : k + 2], "little", signed=True) for k in (0, 2, 4))

    def _read(self, register: Register) -> int:
        return self._read_some(register, 1)[0]

    def _read_some(self, register: Register, count: int) -> bytearray:
        buffer = bytearray(1 + count)
        buffer[0] = READ | register
        self._spi.transaction(buffer)
        return buffer[1:]

    def _write(self, register: Register, value: int, wait_ns: int) -> None:
        self._spi.transaction(bytearray((register, value)))
        self._cpu.delay(wait_ns)


def _one_of(name: str, value: object, allowed: dict[int, int] | dict[str, int] | range) -> None:
    if value not in allowed or isinstance(value, bool):
        choices = ", ".join(map(repr, allowed))
        raise ValueError(f"BMI160 {name} is {value!r}; possible: {choices}")
