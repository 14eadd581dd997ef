"""Test equipment on the DSP's SPI: rate and specific force at the last tick, with errors of a choice.

The document's chapter 5 gives errors of rate and force that its accelerometers cannot have; they come from
here in the profile's feed `equivalent`. Request 0x52, then rate x, y, z and force x, y, z as float32, low
byte first.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hal.machine_code import mypyc_attr
from hal.spi import SpiDevice

LENGTH: Final = 25
REQUEST: Final = bytearray((0x52, *bytes(LENGTH - 1)))
WHOLE: Final = slice(None)
"""`[:]`, made once."""


@mypyc_attr(allow_interpreted_subclasses=True)
class EquivalentFeed:
    """Fills what the packet door takes beside a packet."""

    def __init__(self, device: SpiDevice | None) -> None:
        """None: rate and force are those of the packet."""
        self.felt: NDArray[np.float32] = np.zeros(7, np.float32)
        self._device = device
        self._buffer = bytearray(LENGTH)
        self._answer = memoryview(self._buffer)[1:]
        self._bytes = self.felt.data.cast("B")[4:]
        if device is not None:
            self.felt[0] = 1.0

    def read(self) -> None:
        """At each packet."""
        if self._device is None:
            return
        buffer = self._buffer
        buffer[WHOLE] = REQUEST
        self._device.transaction(buffer)
        self._bytes[WHOLE] = self._answer
