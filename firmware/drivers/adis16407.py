"""ADIS16407 over SPI: identify, configure, read. One attempt a call; not-ready is a result, no exception.

    start           reset, identify, configure, read everything back
    read            one burst: all outputs (the interrupt's call)
    await_sample    the instant at which the outputs are renewed
    check           still there, still configured, what does it report? (the background's call)
    self_test       the chip's own test of sensors, then of its flash
    null_gyros      gyro biases into the offset registers, from the present output or a mean over 30 s
    save            the settings into the flash

An answer comes with the next word. A burst of the interrupt between a request of the background and its
answer takes the answer away; the request is then repeated. The pauses that the part wants between words
stand in the board description: 16-bit words, chip select high for 9 µs, one clock between words of a
burst at up to 1 MHz. From a period of 11 time bases on everything has to be slower: 300 kHz, 75 µs.
Registers, commands and times: fact sheet sections 1 to 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.adis16407_sample import BURST_LENGTH, DEFAULT_GYRO_RANGE_DPS, scales
from hal.cpu import Cpu
from hal.spi import SpiDevice

PRODUCT_ID: Final = 16407
NOBODY: Final = (0x0000, 0xFFFF)
"""What a line without a chip reads as."""
NEW_DATA: Final = 0x8000
LOOKS: Final = 100
"""Words of at least 25 µs: two periods of 1.22 ms."""
ATTEMPTS: Final = 4
"""At an answer that a burst took away."""

MS: Final = 1_000_000
START_UP_NS: Final = 220 * MS
"""210 ms (section 1), and margin for the part's clock."""
SELF_TEST_NS: Final = 50 * MS
FLASH_NS: Final = 100 * MS
"""75 ms for an update (section 5); the sheet tells no time for the two tests."""
PRECISION_NULL_NS: Final = 31_000 * MS


class Register(IntEnum):
    """Addresses that the driver uses."""

    FLASH_CNT = 0x00
    TEMP_OUT = 0x1A
    MSC_CTRL = 0x38
    SMPL_PRD = 0x3A
    SENS_AVG = 0x3C
    DIAG_STAT = 0x40
    GLOB_CMD = 0x42
    ALM_MAG1 = 0x44
    ALM_MAG2 = 0x46
    ALM_SMPL1 = 0x48
    ALM_SMPL2 = 0x4A
    ALM_CTRL = 0x4C
    PROD_ID = 0x56


class Command(IntEnum):
    """Bits of GLOB_CMD."""

    RESET = 0x80
    PRECISION_NULL = 0x10
    SAVE = 0x08
    NULL = 0x01


class Outcome(Enum):
    """What a call found."""

    OK = "ok"
    ABSENT = "nobody answers"
    WRONG_CHIP = "wrong product id"
    NOT_CONFIGURED = "a register does not hold what was written"
    ERROR_FLAG = "the chip reports an error"
    ALARM = "an alarm is active"
    SELF_TEST_FAILED = "the self-test failed"
    NOT_SAVED = "the flash was not written"


GYRO_RANGE_CODES: Final = {300: 0x4, 150: 0x2, 75: 0x1}
ALARM_SOURCES: Final = {
    "supply": 1, "gyro_x": 2, "gyro_y": 3, "gyro_z": 4, "accel_x": 5, "accel_y": 6, "accel_z": 7,
    "magn_x": 8, "magn_y": 9, "magn_z": 10, "baro": 11, "temperature": 12, "adc": 13,
}  # fmt: skip
READY_ENABLE, ACTIVE_HIGH = 0x04, 0x02
SELF_TEST, MEMORY_TEST = 0x0400, 0x0800
ALARM_FLAGS: Final = 0x0300
SELF_TEST_FLAGS: Final = 0xFCE0


@dataclass(frozen=True)
class Alarm:
    """One alarm: `source` above (or below) `threshold` counts of its output; with `samples`, its mean change
    a sample over so many. Raises ValueError for what the chip cannot do."""

    source: str
    threshold: int
    above: bool = True
    samples: int = 0

    def __post_init__(self) -> None:
        _one_of("alarm source", self.source, ALARM_SOURCES)
        _within("alarm threshold", self.threshold, -0x2000, 0x3FFF)
        _within("alarm samples", self.samples, 0, 255)

    def magnitude(self) -> int:
        """ALM_MAG."""
        return self.above << 15 | self.threshold & 0x3FFF


@dataclass(frozen=True)
class Adis16407Config:
    """What is set up. Raises ValueError for what the chip cannot do.

    A sample comes every `period` times 0.61035 ms (2: 819.2 Hz); 1 is the external clock on DIO4. `filter`:
    N for 2^N taps in each of two stages. `data_ready_pin`: DIO 1 or 2, active high, or None. `alarm_pin`
    likewise.
    """

    period: int = 2
    gyro_range_dps: int = DEFAULT_GYRO_RANGE_DPS
    filter: int = 2
    data_ready_pin: int | None = 1
    alarms: tuple[Alarm, ...] = ()
    alarm_pin: int | None = None

    def __post_init__(self) -> None:
        _within("period", self.period, 1, 128)
        _one_of("gyro_range_dps", self.gyro_range_dps, GYRO_RANGE_CODES)
        _within("filter", self.filter, 0, 6)
        _one_of("data_ready_pin", self.data_ready_pin, (1, 2, None))
        _one_of("alarm_pin", self.alarm_pin, (1, 2, None))
        if len(self.alarms) > 2:
            raise ValueError(f"ADIS16407 has {len(self.alarms)} alarms; possible: at most 2")
        if self.alarm_pin is not None and self.alarm_pin == self.data_ready_pin:
            raise ValueError(
                f"ADIS16407 alarm_pin is {self.alarm_pin}, the pin of data ready; possible: the other"
            )

    def registers(self) -> tuple[tuple[Register, int], ...]:
        """What is written, in order; data ready comes last."""
        alarms = self.alarms
        control = 0x10
        for k, alarm in enumerate(alarms):
            control |= ALARM_SOURCES[alarm.source] << (8 + 4 * k) | (alarm.samples > 0) << (6 + k)
        magnitudes = [alarm.magnitude() for alarm in alarms] + [0, 0]
        samples = [alarm.samples for alarm in alarms] + [0, 0]
        return (
            (Register.SENS_AVG, GYRO_RANGE_CODES[self.gyro_range_dps] << 8 | self.filter),
            (Register.SMPL_PRD, self.period - 1),
            (Register.ALM_MAG1, magnitudes[0]),
            (Register.ALM_MAG2, magnitudes[1]),
            (Register.ALM_SMPL1, samples[0]),
            (Register.ALM_SMPL2, samples[1]),
            (Register.ALM_CTRL, control | _pin(self.alarm_pin) if alarms else 0),
            (Register.MSC_CTRL, _pin(self.data_ready_pin)),
        )

    def scales(self) -> NDArray[np.float32]:
        """For `adis16407_sample.convert`."""
        return scales(self.gyro_range_dps)


class Adis16407:
    """One chip. `raw` is the last burst as `adis16407_sample` wants it."""

    def __init__(self, spi: SpiDevice, cpu: Cpu, config: Adis16407Config) -> None:
        self.config = config
        self.detail = 0
        """The word that made the last call fail, or DIAG_STAT."""
        self._spi = spi
        self._cpu = cpu
        self._burst = bytearray(BURST_LENGTH)
        self._request = bytes((Register.GLOB_CMD,)) + bytes(BURST_LENGTH - 1)
        self._bursts = 0
        self.raw: NDArray[np.uint8] = np.frombuffer(self._burst, np.uint8)

    def identify(self) -> Outcome:
        """Who is there?"""
        self.detail = self._read(Register.PROD_ID)
        if self.detail == PRODUCT_ID:
            return Outcome.OK
        return Outcome.ABSENT if self.detail in NOBODY else Outcome.WRONG_CHIP

    def start(self) -> Outcome:
        """Bring the chip up from whatever state it is in; takes 0.44 s."""
        self._cpu.delay(START_UP_NS)
        self._command(Command.RESET, START_UP_NS)
        found = self.identify()
        if found is not Outcome.OK:
            return found
        for register, value in self.config.registers():
            self._write(register, value)
        self._read(Register.DIAG_STAT)
        return self._look()

    def read(self) -> None:
        """All outputs in one burst into `raw`."""
        burst = self._burst
        burst[:] = self._request
        self._bursts += 1
        self._spi.transaction(burst)

    def await_sample(self) -> bool:
        """Return when the outputs have just been renewed, after at most two sample periods; False: they were
        not, or a burst came between. TEMP_OUT is read over and over until its ND bit comes back."""
        bursts = self._bursts
        word = Register.TEMP_OUT
        self._word(word, 0)
        for n in range(LOOKS):
            is_new = self._word(word, 0) & NEW_DATA
            if bursts != self._bursts:
                return False
            if is_new and n:
                return True
        return False

    def check(self) -> Outcome:
        """Is it still the chip that was set up, and without error flags? An alarm is told last.

        The flags of DIAG_STAT clear with this; `detail` holds them."""
        found = self.identify()
        return self._look() if found is Outcome.OK else found

    def _look(self) -> Outcome:
        for register, value in self.config.registers():
            self.detail = self._read(register)
            if self.detail != value:
                return Outcome.NOT_CONFIGURED
        self.detail = self._read(Register.DIAG_STAT)
        if self.detail & ~ALARM_FLAGS:
            return Outcome.ERROR_FLAG
        return Outcome.ALARM if self.detail else Outcome.OK

    def self_test(self) -> Outcome:
        """Sensors and flash; takes 150 ms. `detail` holds the flags of what failed."""
        self._read(Register.DIAG_STAT)
        control = self.config.registers()[-1][1]
        self._write(Register.MSC_CTRL, control | SELF_TEST)
        self._cpu.delay(SELF_TEST_NS)
        self._write(Register.MSC_CTRL, control | MEMORY_TEST)
        self._cpu.delay(FLASH_NS)
        running = self._read(Register.MSC_CTRL)
        self.detail = self._read(Register.DIAG_STAT)
        failed = self.detail & SELF_TEST_FLAGS or running != control
        return Outcome.SELF_TEST_FAILED if failed else Outcome.OK

    def null_gyros(self, precise: bool = False) -> Outcome:
        """Gyro biases into the offset registers and the flash, at rest only; precise takes 31 s."""
        if precise:
            return self._flash(Command.PRECISION_NULL, PRECISION_NULL_NS)
        return self._flash(Command.NULL, FLASH_NS)

    def save(self) -> Outcome:
        """Settings into the flash: they are then those of power-on. It wears out after 10,000 times."""
        return self._flash(Command.SAVE, FLASH_NS)

    def _flash(self, command: Command, wait_ns: int) -> Outcome:
        before = self._read(Register.FLASH_CNT)
        self._command(command, wait_ns)
        self.detail = self._read(Register.FLASH_CNT)
        return Outcome.OK if self.detail == before + 1 & 0xFFFF else Outcome.NOT_SAVED

    def _command(self, command: Command, wait_ns: int) -> None:
        self._word(0x80 | Register.GLOB_CMD, command)
        self._cpu.delay(wait_ns)

    def _read(self, register: Register) -> int:
        answer = 0
        for _ in range(ATTEMPTS):
            bursts = self._bursts
            self._word(register, 0)
            answer = self._word(Register.FLASH_CNT, 0)  # a read without side effects
            if bursts == self._bursts:
                break
        return answer

    def _write(self, register: Register, value: int) -> None:
        self._word(0x80 | register, value & 0xFF)
        self._word(0x80 | register + 1, value >> 8)

    def _word(self, high: int, low: int) -> int:
        """One word; the answer belongs to the word before."""
        buffer = bytearray((high, low))
        self._spi.transaction(buffer)
        return buffer[0] << 8 | buffer[1]


def _pin(pin: int | None) -> int:
    """Enable, polarity and pin as in MSC_CTRL and ALM_CTRL."""
    return 0 if pin is None else READY_ENABLE | ACTIVE_HIGH | (pin - 1)


def _within(name: str, value: int, low: int, high: int) -> None:
    if not low <= value <= high or isinstance(value, bool):
        raise ValueError(f"ADIS16407 {name} is {value!r}; possible: {low} to {high}")


def _one_of(name: str, value: object, allowed: dict[int, int] | dict[str, int] | tuple[object, ...]) -> None:
    if value not in allowed or isinstance(value, bool):
        choices = ", ".join(map(repr, allowed))
        raise ValueError(f"ADIS16407 {name} is {value!r}; possible: {choices}")
