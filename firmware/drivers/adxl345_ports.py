"""The ADXL345's registers through SPI or I²C (fact sheet section 1).

    SPI     first byte R/W, MB, address; MB = 1 counts the address up. Mode 3, at most 5 MHz
    I²C     S addr+W register, data … P;  S addr+W register, Sr addr+R data … P. The address counts up

Nobody at the address of an I²C bus is a result here, not an exception; on SPI it shows in the bytes.
"""

from __future__ import annotations

from typing import Final, Protocol

from hal.errors import BusError
from hal.i2c import I2cBus
from hal.spi import SpiDevice

READ: Final = 0x80
MULTIPLE: Final = 0x40
DATAX0: Final = 0x32
SAMPLE_REQUEST: Final = bytes((READ | MULTIPLE | DATAX0, 0, 0, 0, 0, 0, 0))

ADDRESS: Final = 0x53
ALTERNATIVE_ADDRESS: Final = 0x1D
"""SDO/ALT ADDRESS low and high."""

FIFO_POP_NS: Final = 5_000
"""From the end of a read of the data to the next one, or to FIFO_STATUS (section 5)."""


class RegisterPort(Protocol):
    """How the driver reaches the chip. What did not get through is None or False."""

    pop_wait_ns: int
    """Pause that the FIFO needs between two reads on this bus."""

    def sample(self, buffer: bytearray) -> bool:
        """The six data registers into bytes 1 … 6 of `buffer` (7 bytes) by one burst."""
        ...

    def read(self, register: int, count: int = 1) -> bytearray | None:
        """`count` registers from `register` on."""
        ...

    def write(self, register: int, value: int) -> bool:
        """One register."""
        ...


class SpiPort:
    """Through one chip select of an SPI controller."""

    pop_wait_ns = FIFO_POP_NS

    def __init__(self, spi: SpiDevice) -> None:
        self._transaction = spi.transaction

    def sample(self, buffer: bytearray) -> bool:
        """The six data registers; byte 0 is what came during the address byte."""
        buffer[:] = SAMPLE_REQUEST
        self._transaction(buffer)
        return True

    def read(self, register: int, count: int = 1) -> bytearray | None:
        """`count` registers from `register` on."""
        buffer = bytearray(1 + count)
        buffer[0] = READ | (MULTIPLE if count > 1 else 0) | register
        self._transaction(buffer)
        return buffer[1:]

    def write(self, register: int, value: int) -> bool:
        """One register."""
        self._transaction(bytearray((register, value)))
        return True


class I2cPort:
    """Through an I²C bus."""

    pop_wait_ns = 0
    """The address bytes take longer."""

    def __init__(self, bus: I2cBus, address: int = ADDRESS) -> None:
        if address not in (ADDRESS, ALTERNATIVE_ADDRESS):
            raise ValueError(
                f"ADXL345 address is 0x{address:02X}; possible: 0x{ADDRESS:02X}, 0x{ALTERNATIVE_ADDRESS:02X}"
            )
        self._bus = bus
        self._address = address
        self._data_register = bytes((DATAX0,))

    def sample(self, buffer: bytearray) -> bool:
        """The six data registers."""
        try:
            buffer[1:] = self._bus.transaction(self._address, self._data_register, 6)
        except BusError:
            return False
        return True

    def read(self, register: int, count: int = 1) -> bytearray | None:
        """`count` registers from `register` on."""
        try:
            return bytearray(self._bus.transaction(self._address, bytes((register,)), count))
        except BusError:
            return None

    def write(self, register: int, value: int) -> bool:
        """One register."""
        try:
            self._bus.transaction(self._address, bytes((register, value)))
        except BusError:
            return False
        return True
