"""The I²C controller of a processor as a slave: another processor is the master, by `hal.i2c.I2cBus`.

    S addr+W ack  byte ack … P     ──► taken(), interrupt
    S addr+R ack  byte ack … P     ◄── answer(data); beyond its end 0xFF

A slave that has not begun acknowledges nothing; one whose last write was not taken yet refuses the bytes of
the next.
"""

from typing import Protocol

from hal.interrupts import InterruptLine


class I2cSlavePort(Protocol):
    """One slave address."""

    def begin(self, line: InterruptLine) -> None:
        """Acknowledge from now on; `line` is pended by every write."""
        ...

    def taken(self) -> bytes:
        """What the master wrote last, once; empty when there is nothing new."""
        ...

    def answer(self, data: bytes) -> None:
        """What reads give from now on."""
        ...
