"""The EEPROM: what survives power (fact sheet section 4). Words are little endian."""

from __future__ import annotations

SLAVE_ADDRESS, SOFTWARE_VERSION, OP_MODE_1, OP_MODE_2 = 0x00, 0x02, 0x04, 0x05
SERIAL_NUMBER, DATE_YEAR, DATE_WEEK = 0x06, 0x08, 0x09
DEVIATION, VARIATION, X_OFFSET, FILTER = 0x0A, 0x0C, 0x0E, 0x14
SIZE = 0x16

FILTER_ON, RUN, STANDBY, UPRIGHT_FRONT, UPRIGHT_EDGE, LEVEL = 0x20, 0x10, 0x08, 0x04, 0x02, 0x01
"""Bits of OP mode 1."""
COMPUTING, CALIBRATING = 0x80, 0x40
"""Its read-only bits."""

_RESERVED = (0x01, 0x03)
_READ_ONLY = (0x01, SOFTWARE_VERSION, 0x03, SERIAL_NUMBER, SERIAL_NUMBER + 1, DATE_YEAR, DATE_WEEK)
_ADDRESSES = range(0x10, 0xF7)


class Eeprom:
    """Twenty-two bytes."""

    def __init__(self, serial_number: int, version: int, year: int, week: int) -> None:
        self._bytes = bytearray(SIZE)
        self._told_address: int | None = None
        self._bytes[SLAVE_ADDRESS] = 0x32
        self._bytes[SOFTWARE_VERSION] = version
        self._bytes[OP_MODE_1], self._bytes[OP_MODE_2] = RUN | LEVEL, 0x01
        self._bytes[SERIAL_NUMBER : SERIAL_NUMBER + 2] = serial_number.to_bytes(2, "little")
        self._bytes[DATE_YEAR], self._bytes[DATE_WEEK] = year, week

    def pretend_address(self, value: int | None) -> None:
        """Have another address byte read; None: the true one again."""
        self._told_address = value

    def __getitem__(self, address: int) -> int:
        return self._bytes[address]

    def word(self, address: int) -> int:
        """A signed word."""
        return int.from_bytes(self._bytes[address : address + 2], "little", signed=True)

    def set_word(self, address: int, value: int) -> None:
        """The chip itself stores a signed word."""
        self._bytes[address : address + 2] = value.to_bytes(2, "little", signed=True)

    def read(self, address: int) -> tuple[int, str]:
        """A byte for the bus, and what is wrong with asking for it."""
        if address >= SIZE:
            return 0xFF, f"EEPROM 0x{address:02X} does not exist"
        wrong = f"EEPROM 0x{address:02X} is reserved" if address in _RESERVED else ""
        if address == SLAVE_ADDRESS and self._told_address is not None:
            return self._told_address, wrong
        return self._bytes[address], wrong

    def write(self, address: int, value: int) -> str:
        """A byte from the bus. Returns what is wrong with it; then nothing is stored."""
        if address >= SIZE:
            return f"EEPROM 0x{address:02X} does not exist"
        if address in _READ_ONLY:
            return f"EEPROM 0x{address:02X} is not for users"
        if address == SLAVE_ADDRESS and value not in _ADDRESSES:
            return f"slave address 0x{value:02X}; legal are 0x10 to 0xF6"
        if address == OP_MODE_2 and (value & 0xFC or value == 0x03):
            return f"OP mode 2 of 0x{value:02X}; only 0x00, 0x01 and 0x02 are assigned"
        self._bytes[address] = value & ~(COMPUTING | CALIBRATING) if address == OP_MODE_1 else value
        return ""
