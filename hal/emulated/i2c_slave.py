"""A processor's I²C controller as a slave, on virtual time: what the master's bus talks to."""

from __future__ import annotations

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import EmulatedLine, emulated_line
from hal.interrupts import InterruptLine

IDLE = 0xFF


class EmulatedI2cSlave:
    """Implements `hal.i2c_slave.I2cSlavePort` and, towards the bus, `hal.emulated.i2c.I2cSlave`."""

    def __init__(self, cpu: EmulatedCpu) -> None:
        self.transactions = 0
        self.busy_ns = 0
        """Its hardware works beside the processor; the bus counts its own time."""
        self._written = b""
        self._answer = b""
        self._line: EmulatedLine | None = None
        cpu.reset_hooks.append(self._reset)

    def begin(self, line: InterruptLine) -> None:
        """See `hal.i2c_slave.I2cSlavePort`."""
        self._written = self._answer = b""
        self._line = emulated_line(line)

    def taken(self) -> bytes:
        """See `hal.i2c_slave.I2cSlavePort`."""
        data, self._written = self._written, b""
        return data

    def answer(self, data: bytes) -> None:
        """See `hal.i2c_slave.I2cSlavePort`."""
        self._answer = bytes(data)

    def listens(self, _time_ns: int) -> bool:
        """Whether it acknowledges its address."""
        return self._line is not None

    def write(self, data: bytes, _time_ns: int) -> int:
        """The master has written; returns how many of the bytes are acknowledged."""
        line = self._line
        if line is None or self._written:
            return 0
        self.transactions += 1
        self._written = data
        line.request()
        return len(data)

    def read(self, length: int, _time_ns: int) -> bytes:
        """The master reads."""
        self.transactions += 1
        return self._answer[:length].ljust(length, bytes((IDLE,)))

    def _reset(self) -> None:
        self._line = None
        self._written = self._answer = b""
