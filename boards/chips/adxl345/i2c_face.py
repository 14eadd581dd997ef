"""The I²C slave: a register pointer that the first written byte sets and every further byte moves on."""

from __future__ import annotations

from typing import Protocol

from boards.chips.registers import AccessLog, ReportKind

_FASTEST_HZ = 400_000
_POINTER = 0x3F


class RegisterBus(Protocol):
    """What the face needs of the chip."""

    log: AccessLog
    powered: bool
    """Whether the chip acknowledges its address."""

    def i2c_read(self, address: int, count: int, time_ns: int) -> bytes:
        """A burst read."""
        ...

    def i2c_write(self, address: int, data: bytes, time_ns: int) -> None:
        """A burst write."""
        ...


class I2cFace:
    """The chip at its 7-bit `address`."""

    def __init__(self, chip: RegisterBus, address: int) -> None:
        self.address = address
        self._chip = chip
        self._pointer = 0
        self._too_fast = False

    def clocked_at(self, frequency_hz: int) -> None:
        """The bus tells its clock."""
        self._too_fast = frequency_hz > _FASTEST_HZ

    def listens(self, _time_ns: int) -> bool:
        """Whether the chip acknowledges its address."""
        return self._chip.powered

    def write(self, data: bytes, time_ns: int) -> int:
        """Bytes from the master: register address, then values. Returns how many were acknowledged."""
        if not self._chip.powered:
            return 0
        if self._too_fast:
            self._report_clock(time_ns)
        if data:
            if data[0] & ~_POINTER:
                detail = f"register address 0x{data[0]:02X} has more than six bits; the upper two are dropped"
                self._chip.log.report(ReportKind.PROTOCOL, "I2C", detail, time_ns)
            self._pointer = data[0] & _POINTER
            if len(data) > 1:
                self._chip.i2c_write(self._pointer, data[1:], time_ns)
                self._pointer = (self._pointer + len(data) - 1) & _POINTER
        return len(data)

    def read(self, length: int, time_ns: int) -> bytes:
        """Bytes to the master from the register pointer on; 0xFF (an idle bus) without power."""
        if not self._chip.powered:
            return b"\xff" * length
        if self._too_fast:
            self._report_clock(time_ns)
        first = self._pointer
        self._pointer = (first + length) & _POINTER
        return self._chip.i2c_read(first, length, time_ns)

    def _report_clock(self, time_ns: int) -> None:
        detail = "clock faster than 400 kHz: undefined, served as if it were slower"
        self._chip.log.report(ReportKind.TIMING, "I2C", detail, time_ns)
