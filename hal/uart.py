"""UART: asynchronous serial port, 8 data bits, no parity, 1 stop bit.

    idle ‾‾‾\\_start_/ d0 d1 d2 d3 d4 d5 d6 d7 /‾stop‾\\ …      10 bits a byte

Transmission goes by DMA: `write` returns at once and the line works the queue off. Reception goes by
circular DMA into a ring that the firmware owns; the interrupt line given at `start_receive` is pended
when half the ring is full, when it wraps, and when the line falls idle after data.
"""

from typing import Protocol

from hal.interrupts import InterruptLine


class Uart(Protocol):
    """One port."""

    @property
    def baud(self) -> int:
        """The bit rate of both directions now."""
        ...

    def set_baud(self, baud: int) -> None:
        """Change the bit rate of both directions for the bytes that follow."""
        ...

    def write(self, data: bytes) -> int:
        """Queue bytes for transmission and return how many were taken (0 … len(data))."""
        ...

    def tx_free(self) -> int:
        """Room left in the transmit queue, in bytes."""
        ...

    def start_receive(self, ring: bytearray, line: InterruptLine) -> None:
        """Receive into `ring` by circular DMA from its first byte on."""
        ...

    def received(self) -> int:
        """Bytes put into the ring since `start_receive`, never wrapped; the write index is this modulo
        the ring's length. More than a ring ahead of the reader means that data were overwritten."""
        ...

    def take_errors(self) -> int:
        """Framing errors and overruns since the last call."""
        ...
