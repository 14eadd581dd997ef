"""ADXL345 over SPI or I²C: identify, configure, read. One attempt a call; not-ready is a result, never an
exception.

    start       standby, identify, configure, read everything back, measure
    read        the six data bytes in one burst (the interrupt's or the timer's call)
    read_fifo   what waits in the FIFO
    check       still there, still measuring, still configured? (the background's call)
    self_test   the chip's own test, `start` afterwards

The part has no software reset: `start` writes whatever could have been left over. Whoever gets another
outcome than OK from `check` calls `start` again, since a chip whose supply dipped is in standby with the
settings of power-on. Registers and procedures: fact sheet sections 1 to 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.adxl345_ports import RegisterPort
from firmware.drivers.adxl345_sample import SAMPLE_LENGTH
from hal.cpu import Cpu

DEVICE_ID: Final = 0xE5
NOBODY: Final = (0x00, 0xFF)
"""What a line without a chip reads as."""

TURN_ON_NS: Final = 1_100_000
"""From standby to the first sample: this and one sample period (section 2)."""
FIFO_ENTRIES: Final = 32


class Register(IntEnum):
    """Addresses that the driver uses."""

    DEVID = 0x00
    OFSX = 0x1E
    OFSY = 0x1F
    OFSZ = 0x20
    BW_RATE = 0x2C
    POWER_CTL = 0x2D
    INT_ENABLE = 0x2E
    INT_MAP = 0x2F
    DATA_FORMAT = 0x31
    FIFO_CTL = 0x38
    FIFO_STATUS = 0x39


class Outcome(Enum):
    """What a call found."""

    OK = "ok"
    ABSENT = "nobody answers"
    WRONG_CHIP = "wrong device id"
    NOT_CONFIGURED = "a register does not hold what was written"
    SELF_TEST_FAILED = "the self-test failed"


RATE_CODES: Final = {
    3200: 0xF, 1600: 0xE, 800: 0xD, 400: 0xC, 200: 0xB, 100: 0xA, 50: 0x9, 25: 0x8,
    12.5: 0x7, 6.25: 0x6, 3.13: 0x5, 1.56: 0x4, 0.78: 0x3, 0.39: 0x2, 0.20: 0x1, 0.10: 0x0,
}  # fmt: skip
RANGE_CODES: Final = {2: 0, 4: 1, 8: 2, 16: 3}
FIFO_MODES: Final = {"bypass": 0x00, "fifo": 0x40, "stream": 0x80}
FASTEST_PERIOD_NS: Final = 312_500

SELF_TEST, THREE_WIRE, FULL_RESOLUTION = 0x80, 0x40, 0x08
LOW_POWER: Final = 0x10
STANDBY, MEASURE = 0x00, 0x08
DATA_READY, WATERMARK = 0x80, 0x02
ENTRIES_MASK: Final = 0x3F

TEST_RATE: Final = 0x0A
TEST_FORMAT: Final = FULL_RESOLUTION | 0x03
TEST_PERIOD_NS: Final = 10_000_000
TEST_SETTLING, TEST_SAMPLES = 5, 10
"""Samples until the deflection stands (4), and in each mean: 0.1 s (section 3)."""
TEST_LIMITS: Final = ((50, 540), (-540, -50), (75, 875))
"""LSB at 2.5 V, x, y, z."""
SUPPLIES_V: Final = (2.0, 2.5, 3.3, 3.6)
SUPPLY_FACTORS: Final = ((0.64, 1.0, 1.77, 2.11), (0.64, 1.0, 1.77, 2.11), (0.80, 1.0, 1.47, 1.69))


@dataclass(frozen=True)
class Adxl345Config:
    """What is set up. Raises ValueError for what the chip cannot do.

    Data are in full resolution, 256 LSB per g. `fifo`: "bypass", "fifo" or "stream"; `interrupt_pin`: 1 or 2
    shows data ready in bypass mode, else the `watermark`; None leaves the pins alone. `offsets`: counts of
    15.6 mg that the chip adds. `supply_v` scales the limits of the self-test.
    """

    rate_hz: float = 100
    range_g: int = 16
    low_power: bool = False
    three_wire: bool = False
    fifo: str = "bypass"
    watermark: int = 16
    interrupt_pin: int | None = None
    offsets: tuple[int, int, int] = (0, 0, 0)
    supply_v: float = 2.5

    def __post_init__(self) -> None:
        _one_of("rate_hz", self.rate_hz, tuple(RATE_CODES))
        _one_of("range_g", self.range_g, tuple(RANGE_CODES))
        _one_of("fifo", self.fifo, tuple(FIFO_MODES))
        _one_of("interrupt_pin", self.interrupt_pin, (None, 1, 2))
        if not 1 <= self.watermark <= 31:
            raise ValueError(f"ADXL345 watermark is {self.watermark!r}; possible: 1 to 31 samples")
        if len(self.offsets) != 3 or not all(-128 <= count <= 127 for count in self.offsets):
            raise ValueError(
                f"ADXL345 offsets are {self.offsets!r}; three counts of -128 to 127, e.g. (0, 0, -3)"
            )
        if not SUPPLIES_V[0] <= self.supply_v <= SUPPLIES_V[-1]:
            raise ValueError(f"ADXL345 supply_v is {self.supply_v!r}; possible: 2.0 to 3.6, e.g. 3.3")

    @property
    def data_format(self) -> int:
        """DATA_FORMAT."""
        return (THREE_WIRE if self.three_wire else 0) | FULL_RESOLUTION | RANGE_CODES[self.range_g]

    @property
    def period_ns(self) -> int:
        """Nominal time between two samples."""
        return FASTEST_PERIOD_NS << (0xF - RATE_CODES[self.rate_hz])

    def registers(self) -> tuple[tuple[Register, int], ...]:
        """The writes, in order; all but POWER_CTL in standby, the FIFO emptied by bypass mode before."""
        source = DATA_READY if self.fifo == "bypass" else WATERMARK
        x, y, z = (count & 0xFF for count in self.offsets)
        return (
            (Register.DATA_FORMAT, self.data_format),
            (Register.BW_RATE, (LOW_POWER if self.low_power else 0) | RATE_CODES[self.rate_hz]),
            (Register.OFSX, x),
            (Register.OFSY, y),
            (Register.OFSZ, z),
            (Register.INT_MAP, 0xFF if self.interrupt_pin == 2 else 0x00),
            (Register.FIFO_CTL, FIFO_MODES[self.fifo] | self.watermark),
            (Register.INT_ENABLE, source if self.interrupt_pin else 0x00),
            (Register.POWER_CTL, MEASURE),
        )


class Adxl345:
    """One chip. `raw` is the last sample as `adxl345_sample` wants it, `fifo` holds those of `read_fifo`."""

    def __init__(self, port: RegisterPort, cpu: Cpu, config: Adxl345Config) -> None:
        self.config = config
        self.detail = 0
        """The byte that made the last call fail."""
        self._port = port
        self._cpu = cpu
        self._sample = port.sample
        self._burst = bytearray(SAMPLE_LENGTH)
        self.raw: NDArray[np.uint8] = np.frombuffer(self._burst, np.uint8)
        self.fifo: NDArray[np.uint8] = np.zeros((FIFO_ENTRIES, SAMPLE_LENGTH), np.uint8)

    def identify(self) -> Outcome:
        """Ask who is there."""
        self.detail = self._read(Register.DEVID)
        if self.detail == DEVICE_ID:
            return Outcome.OK
        return Outcome.ABSENT if self.detail in NOBODY else Outcome.WRONG_CHIP

    def start(self) -> Outcome:
        """Bring the chip up from whatever state it is in, until the first sample has come: 1.1 ms and 1.1
        periods. In bypass mode that sample is read, so that the next one raises the data-ready pin."""
        config = self.config
        self._port.write(Register.POWER_CTL, STANDBY)
        self._port.write(Register.DATA_FORMAT, config.data_format)
        found = self.identify()
        if found is not Outcome.OK:
            return found
        self._port.write(Register.INT_ENABLE, 0x00)
        self._port.write(Register.FIFO_CTL, 0x00)
        for register, value in config.registers():
            self._port.write(register, value)
        held = self._holds(config.registers())
        if held is Outcome.OK:
            self._cpu.delay(TURN_ON_NS + config.period_ns * 11 // 10)
            if config.fifo == "bypass":
                self.read()
        return held

    def read(self) -> bool:
        """The six data bytes in one burst into `raw`; False when nobody acknowledged (I²C)."""
        return self._sample(self._burst)

    def read_fifo(self) -> int:
        """What waits in the FIFO into the first rows of `fifo`; returns how many."""
        entries = self._port.read(Register.FIFO_STATUS)
        if entries is None:
            return 0
        count = min(entries[0] & ENTRIES_MASK, FIFO_ENTRIES)
        for row in range(count):
            if not self._sample(self._burst):
                return row
            self.fifo[row] = self.raw
            if self._port.pop_wait_ns:
                self._cpu.delay(self._port.pop_wait_ns)
        return count

    def check(self) -> Outcome:
        """Is it still the chip that was set up, and measuring?"""
        found = self.identify()
        return found if found is not Outcome.OK else self._holds(self.config.registers())

    def self_test(self) -> Outcome:
        """Deflect the sensor from within; takes 0.3 s, and `start` is needed afterwards. At rest only."""
        port = self._port
        keep = THREE_WIRE if self.config.three_wire else 0
        for register, value in (
            (Register.POWER_CTL, STANDBY),
            (Register.INT_ENABLE, 0x00),
            (Register.FIFO_CTL, 0x00),
            (Register.BW_RATE, TEST_RATE),
            (Register.DATA_FORMAT, keep | TEST_FORMAT),
            (Register.POWER_CTL, MEASURE),
        ):
            port.write(register, value)
        self._cpu.delay(TURN_ON_NS)
        at_rest = self._mean()
        port.write(Register.DATA_FORMAT, keep | SELF_TEST | TEST_FORMAT)
        deflected = self._mean()
        port.write(Register.DATA_FORMAT, keep | TEST_FORMAT)
        if at_rest is None or deflected is None:
            return Outcome.ABSENT
        for axis, (low, high) in enumerate(TEST_LIMITS):
            factor = float(np.interp(self.config.supply_v, SUPPLIES_V, SUPPLY_FACTORS[axis]))
            if not low * factor <= deflected[axis] - at_rest[axis] <= high * factor:
                self.detail = axis
                return Outcome.SELF_TEST_FAILED
        return Outcome.OK

    def _mean(self) -> tuple[float, ...] | None:
        """Mean counts of 0.1 s, once what was switched has settled."""
        total = np.zeros(3)
        self._cpu.delay(TEST_SETTLING * TEST_PERIOD_NS)
        for _ in range(TEST_SAMPLES):
            self._cpu.delay(TEST_PERIOD_NS)
            if not self.read():
                return None
            total += self.raw[1:].view("<i2")
        return tuple(total / TEST_SAMPLES)

    def _holds(self, registers: tuple[tuple[Register, int], ...]) -> Outcome:
        for register, value in registers:
            self.detail = self._read(register)
            if self.detail != value:
                return Outcome.NOT_CONFIGURED
        return Outcome.OK

    def _read(self, register: Register) -> int:
        """One register; what nobody acknowledges reads as an idle bus."""
        data = self._port.read(register)
        return data[0] if data is not None else NOBODY[1]


def _one_of(name: str, value: object, allowed: tuple[object, ...]) -> None:
    if value not in allowed or isinstance(value, bool):
        choices = ", ".join(map(repr, allowed))
        raise ValueError(f"ADXL345 {name} is {value!r}; possible: {choices}")
