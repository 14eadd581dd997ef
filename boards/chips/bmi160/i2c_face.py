"""The I²C slave: a register pointer that the first written byte sets and every further byte moves on."""

from __future__ import annotations

from typing import Protocol

from boards.chips.bmi160.register_map import FIFO_DATA


class RegisterBus(Protocol):
    """What the face needs of the chip."""

    def i2c_listens(self, time_ns: int) -> bool:
        """Whether the chip acknowledges its address."""
        ...

    def read_registers(self, address: int, count: int, time_ns: int) -> bytes:
        """A burst read."""
        ...

    def write_registers(self, address: int, data: bytes, start_ns: int, end_ns: int) -> None:
        """A burst write."""
        ...


class I2cFace:
    """The chip at its 7-bit `address`."""

    def __init__(self, chip: RegisterBus, address: int) -> None:
        self.address = address
        self._chip = chip
        self._pointer = 0

    def listens(self, time_ns: int) -> bool:
        """Whether the chip acknowledges its address."""
        return self._chip.i2c_listens(time_ns)

    def write(self, data: bytes, time_ns: int) -> int:
        """Bytes from the master: register address, then values. Returns how many were acknowledged."""
        if not self._chip.i2c_listens(time_ns):
            return 0
        if data:
            self._pointer = data[0] & 0x7F
            self._chip.write_registers(self._pointer, data[1:], time_ns, time_ns)
            self._move(len(data) - 1)
        return len(data)

    def read(self, length: int, time_ns: int) -> bytes:
        """Bytes to the master from the register pointer on; 0xFF (an idle bus) when not listening."""
        if not self._chip.i2c_listens(time_ns):
            return b"\xff" * length
        data = self._chip.read_registers(self._pointer, length, time_ns)
        self._move(length)
        return data

    def _move(self, count: int) -> None:
        stays = FIFO_DATA - self._pointer if self._pointer <= FIFO_DATA < self._pointer + count else count
        self._pointer = (self._pointer + stays) & 0x7F
