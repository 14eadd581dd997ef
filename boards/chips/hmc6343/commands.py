"""The commands as data (fact sheet section 3): arguments, response, delay."""

from __future__ import annotations

from dataclasses import dataclass

MICROSECOND, MILLISECOND = 1_000, 1_000_000

POST_ACCELEROMETER, POST_MAGNETOMETER, POST_HEADING, POST_TILT, POST_OP_MODE = 0x40, 0x45, 0x50, 0x55, 0x65
ENTER_CALIBRATION, LEVEL, EDGE, FRONT, RUN, STANDBY, EXIT_CALIBRATION = (
    0x71,
    0x72,
    0x73,
    0x74,
    0x75,
    0x76,
    0x7E,
)
RESET, SLEEP, WAKE, READ_EEPROM, WRITE_EEPROM = 0x82, 0x83, 0x84, 0xE1, 0xF1

ALIASES = {0x70: ENTER_CALIBRATION, 0x7F: EXIT_CALIBRATION}
"""Of the preliminary data sheet."""

POWER_UP_NS = 500 * MILLISECOND
"""After the supply and after a reset the part does not answer for so long."""


@dataclass(frozen=True, slots=True)
class Command:
    """One command: how many argument and response bytes, and how long until the response or the next one."""

    name: str
    delay_ns: int
    arguments: int = 0
    response: int = 0


POST_NS, _SHORT_NS, _EEPROM_NS = 1 * MILLISECOND, 300 * MICROSECOND, 10 * MILLISECOND

COMMANDS = {
    POST_ACCELEROMETER: Command("post accelerometer", POST_NS, response=6),
    POST_MAGNETOMETER: Command("post magnetometer", POST_NS, response=6),
    POST_HEADING: Command("post heading", POST_NS, response=6),
    POST_TILT: Command("post tilt", POST_NS, response=6),
    POST_OP_MODE: Command("post OP mode 1", POST_NS, response=1),
    ENTER_CALIBRATION: Command("enter calibration", _SHORT_NS),
    LEVEL: Command("level orientation", _SHORT_NS),
    EDGE: Command("upright edge orientation", _SHORT_NS),
    FRONT: Command("upright front orientation", _SHORT_NS),
    RUN: Command("run", _SHORT_NS),
    STANDBY: Command("standby", _SHORT_NS),
    EXIT_CALIBRATION: Command("exit calibration", 50 * MILLISECOND),
    RESET: Command("reset", POWER_UP_NS),
    SLEEP: Command("sleep", 1 * MILLISECOND),
    WAKE: Command("leave sleep", 20 * MILLISECOND),
    READ_EEPROM: Command("read EEPROM", _EEPROM_NS, arguments=1, response=1),
    WRITE_EEPROM: Command("write EEPROM", _EEPROM_NS, arguments=2),
}
