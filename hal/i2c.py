"""I²C master.

    S addr+W ack  byte ack … (Sr addr+R ack  byte ack … byte nack)  P

`transaction` sends `write` when it is not empty, then reads `read_length` bytes after a repeated start
when that is not zero. With both empty it addresses the device and stops (a presence check).
"""

from typing import Protocol


class I2cBus(Protocol):
    """One bus; devices are told apart by their 7-bit address."""

    def transaction(self, address: int, write: bytes = b"", read_length: int = 0) -> bytes:
        """Run one transaction and return the bytes read.

        Raises BusError: ADDRESS_NACK when nobody answers, DATA_NACK when a byte written is refused,
        TIMEOUT when the clock is stretched for too long.
        """
        ...
