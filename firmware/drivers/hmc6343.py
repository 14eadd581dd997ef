"""HMC6343 over I²C: identify, configure, read. One attempt a call; nobody there is a result, no exception.

    start       wait for power-up, identify, bring the EEPROM to the settings, orientation, run mode
    read        heading, pitch and roll into `raw` (1 ms of waiting for the response)
    check       still there, still running, right way up?
    check_promptness    the same, and whether an answer is there when it should be
    begin_calibration, end_calibration      around the turns that the fact sheet tells (section 5)

Every command is followed by its delay (section 3). The EEPROM is written only where it differs; the part
takes its settings over at a reset, which follows then. The bus runs at 100 kHz.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.hmc6343_sample import RESPONSE_LENGTH
from hal.cpu import Cpu
from hal.errors import BusError
from hal.i2c import I2cBus

ADDRESS: Final = 0x19
POWER_UP_NS: Final = 500_000_000
"""After the supply and after a reset (section 3)."""
LATE_POST_NS: Final = 20_000_000
"""What a part that is late gets instead of POST_NS."""
POST_NS, COMMAND_NS, EEPROM_NS = 1_000_000, 300_000, 10_000_000
EXIT_CALIBRATION_NS: Final = 50_000_000
SLEEP_NS, WAKE_NS = 1_000_000, 20_000_000


class Command(IntEnum):
    """Command bytes that the driver uses."""

    POST_ACCELEROMETER = 0x40
    POST_MAGNETOMETER = 0x45
    POST_HEADING = 0x50
    POST_TILT = 0x55
    POST_OP_MODE = 0x65
    ENTER_CALIBRATION = 0x71
    LEVEL = 0x72
    EDGE = 0x73
    FRONT = 0x74
    RUN = 0x75
    EXIT_CALIBRATION = 0x7E
    RESET = 0x82
    SLEEP = 0x83
    WAKE = 0x84
    READ_EEPROM = 0xE1
    WRITE_EEPROM = 0xF1


HEADING_REQUEST: Final = bytes((Command.POST_HEADING,))


class Outcome(Enum):
    """What a call found."""

    OK = "ok"
    ABSENT = "nobody answers"
    WRONG_CHIP = "not an HMC6343 at its factory address"
    NOT_CONFIGURED = "the EEPROM does not hold what was written"
    NOT_RUNNING = "not in run mode, or another orientation"
    LATE = "answers late"


EEPROM_ADDRESS, OP_MODE_1, OP_MODE_2, DEVIATION, VARIATION, FILTER = 0x00, 0x04, 0x05, 0x0A, 0x0C, 0x14
FACTORY_ADDRESS: Final = 0x32
RATE_CODES: Final = {1: 0x00, 5: 0x01, 10: 0x02}
ORIENTATIONS: Final = {
    "level": (Command.LEVEL, 0x01),
    "edge": (Command.EDGE, 0x02),
    "front": (Command.FRONT, 0x04),
}
FILTER_BIT, RUN_BIT, STANDBY_BIT, ORIENTATION_MASK = 0x20, 0x10, 0x08, 0x07


@dataclass(frozen=True)
class Hmc6343Config:
    """What is set up. Raises ValueError for what the part cannot do.

    `filter`: how many earlier headings are weighed besides the newest. `deviation`, `variation`: tenths of a
    degree that the part adds to the heading.
    """

    rate_hz: int = 5
    orientation: str = "level"
    filter: int = 0
    deviation: int = 0
    variation: int = 0

    def __post_init__(self) -> None:
        _one_of("rate_hz", self.rate_hz, tuple(RATE_CODES))
        _one_of("orientation", self.orientation, tuple(ORIENTATIONS))
        _one_of("filter", self.filter, tuple(range(16)))
        for name, tenths in (("deviation", self.deviation), ("variation", self.variation)):
            if not -1800 <= tenths <= 1800:
                raise ValueError(f"HMC6343 {name} is {tenths!r}; possible: -1800 to 1800 tenths of a degree")

    @property
    def op_mode(self) -> int:
        """OP mode 1 in run mode."""
        return (FILTER_BIT if self.filter else 0) | RUN_BIT | ORIENTATIONS[self.orientation][1]

    def eeprom(self) -> tuple[tuple[int, int], ...]:
        """Addresses and bytes."""
        deviation, variation = self.deviation & 0xFFFF, self.variation & 0xFFFF
        return (
            (OP_MODE_1, self.op_mode),
            (OP_MODE_2, RATE_CODES[self.rate_hz]),
            (DEVIATION, deviation & 0xFF),
            (DEVIATION + 1, deviation >> 8),
            (VARIATION, variation & 0xFF),
            (VARIATION + 1, variation >> 8),
            (FILTER, self.filter),
            (FILTER + 1, 0),
        )


class Hmc6343:
    """One part. `raw` is the last response to `read` as `hmc6343_sample` wants it."""

    def __init__(self, bus: I2cBus, cpu: Cpu, config: Hmc6343Config) -> None:
        self.config = config
        self.detail = 0
        """The byte that made the last call fail."""
        self._bus = bus
        self._cpu = cpu
        self._post_ns = POST_NS
        self._response = bytearray(RESPONSE_LENGTH)
        self.raw: NDArray[np.uint8] = np.frombuffer(self._response, np.uint8)

    def identify(self) -> Outcome:
        """The part has no identity; its own address in its EEPROM stands for it."""
        found = self._eeprom(EEPROM_ADDRESS)
        if found is None:
            return Outcome.ABSENT
        self.detail = found
        return Outcome.OK if found == FACTORY_ADDRESS else Outcome.WRONG_CHIP

    def start(self) -> Outcome:
        """Bring the part up; takes 0.6 s, and 0.5 s more when its EEPROM had to be changed."""
        self._post_ns = POST_NS
        self._cpu.delay(POWER_UP_NS)
        self._command(WAKE_NS, Command.WAKE)
        found = self.identify()
        if found is not Outcome.OK:
            return found
        differing = [(at, byte) for at, byte in self.config.eeprom() if self._eeprom(at) != byte]
        for at, byte in differing:
            self._command(EEPROM_NS, Command.WRITE_EEPROM, at, byte)
        if differing:
            self._command(POWER_UP_NS, Command.RESET)
        for at, byte in differing:
            held = self._eeprom(at)
            if held != byte:
                self.detail = held or 0
                return Outcome.NOT_CONFIGURED
        self._command(COMMAND_NS, ORIENTATIONS[self.config.orientation][0])
        mode = self._ask(POST_NS, 1, Command.POST_OP_MODE)
        if mode is not None and not mode[0] & RUN_BIT:
            self._command(COMMAND_NS, Command.RUN)
        return self.check()

    def check(self) -> Outcome:
        """Still there, running, right way up?"""
        mode = self._ask(POST_NS, 1, Command.POST_OP_MODE)
        if mode is None:
            return Outcome.ABSENT
        self.detail = mode[0]
        return Outcome.OK if self._is_running(mode[0]) else Outcome.NOT_RUNNING

    def check_promptness(self) -> Outcome:
        """Behind a `read`. A part that takes longer than its delay answers with what it was asked before:
        it is LATE, and `read` waits LATE_POST_NS until the part is prompt again. Takes 1.5 ms, 45 ms
        when it is late; what is later than LATE_POST_NS does not run."""
        mode = self._ask(POST_NS, 1, Command.POST_OP_MODE)
        if mode is not None and self._is_running(mode[0]):
            self._post_ns = POST_NS
            return Outcome.OK
        if mode is not None and mode[0] == self._response[0]:
            self._post_ns = LATE_POST_NS
        self._cpu.delay(LATE_POST_NS)
        mode = self._ask(LATE_POST_NS, 1, Command.POST_OP_MODE)
        if mode is None:
            return Outcome.ABSENT
        self.detail = mode[0]
        if not self._is_running(mode[0]):
            return Outcome.NOT_RUNNING
        return Outcome.OK if self._post_ns == POST_NS else Outcome.LATE

    def read(self) -> bool:
        """Heading, pitch, roll into `raw`; False when nobody acknowledged."""
        try:
            self._bus.transaction(ADDRESS, HEADING_REQUEST)
            self._cpu.delay(self._post_ns)
            self._response[:] = self._bus.transaction(ADDRESS, b"", RESPONSE_LENGTH)
        except BusError:
            return False
        return True

    def temperature(self) -> float | None:
        """°C."""
        response = self._ask(POST_NS, RESPONSE_LENGTH, Command.POST_TILT)
        return None if response is None else int.from_bytes(response[4:6], "big", signed=True) / 10.0

    def vectors(self) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
        """Counts of the accelerometer and of the magnetometer, x, y, z."""
        force = self._ask(POST_NS, RESPONSE_LENGTH, Command.POST_ACCELEROMETER)
        field = self._ask(POST_NS, RESPONSE_LENGTH, Command.POST_MAGNETOMETER)
        return None if force is None or field is None else (_words(force), _words(field))

    def begin_calibration(self) -> bool:
        """From now on the part watches the field."""
        return self._command(COMMAND_NS, Command.ENTER_CALIBRATION)

    def end_calibration(self) -> bool:
        """The part works its offsets out and keeps them."""
        return self._command(EXIT_CALIBRATION_NS, Command.EXIT_CALIBRATION)

    def sleep(self) -> bool:
        """The analogue part off; `start` wakes."""
        return self._command(SLEEP_NS, Command.SLEEP)

    def _is_running(self, mode: int) -> bool:
        mask = FILTER_BIT | RUN_BIT | STANDBY_BIT | ORIENTATION_MASK
        return (mode ^ self.config.op_mode) & mask == 0

    def _eeprom(self, address: int) -> int | None:
        data = self._ask(EEPROM_NS, 1, Command.READ_EEPROM, address)
        return None if data is None else data[0]

    def _ask(self, delay_ns: int, length: int, *command: int) -> bytes | None:
        if not self._command(delay_ns, *command):
            return None
        try:
            return self._bus.transaction(ADDRESS, b"", length)
        except BusError:
            return None

    def _command(self, delay_ns: int, *command: int) -> bool:
        try:
            self._bus.transaction(ADDRESS, bytes(command))
        except BusError:
            return False
        self._cpu.delay(delay_ns)
        return True


def _words(data: bytes) -> tuple[int, ...]:
    return tuple(int.from_bytes(data[k : k + 2], "big", signed=True) for k in (0, 2, 4))


def _one_of(name: str, value: object, allowed: tuple[object, ...]) -> None:
    if value not in allowed or isinstance(value, bool):
        choices = ", ".join(map(repr, allowed))
        raise ValueError(f"HMC6343 {name} is {value!r}; possible: {choices}")
