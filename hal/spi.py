"""SPI master, one device.

    CS   ‾‾\\____________________________/‾‾
    SCLK ---|8 bits|8 bits| … |8 bits|-----
    MOSI     b[0]   b[1]        b[n-1]        what the buffer holds before
    MISO     b[0]   b[1]        b[n-1]        what the buffer holds after

A driver never touches chip select. A backend holds it low over the whole transaction and releases it
before returning, also when it raises. Clock, mode and word stalls stand in the board description.
"""

from typing import Protocol


class SpiDevice(Protocol):
    """One slave behind one chip select."""

    def transaction(self, buffer: bytearray) -> None:
        """Exchange the whole buffer in place, most significant bit first.

        Must not change the buffer's length. An absent slave is not an error on this bus: the line floats
        and the buffer comes back as 0xFF or 0x00.
        """
        ...
