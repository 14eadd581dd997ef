"""The flash: settings that survive reset and supply, a wear counter, a checksum that a cut update breaks."""

from __future__ import annotations

from boards.chips.adis16407.register_map import REGISTERS, SAVED

ENDURANCE = 10_000


class Flash:
    """A copy of the saved registers, two bytes each."""

    def __init__(self, count: int) -> None:
        resets = {register.address: register.reset for register in REGISTERS}
        self._factory = {address: (resets[address], resets[address + 1]) for address in SAVED}
        self._content = dict(self._factory)
        self.count = count
        """Updates so far, 16 bits."""
        self.corrupt = False
        """The checksum is wrong."""

    def load(self, values: bytearray) -> None:
        """Into the register file; factory settings when the checksum is wrong."""
        for address, pair in (self._factory if self.corrupt else self._content).items():
            values[address : address + 2] = bytes(pair)

    def save(self, values: bytearray) -> None:
        """An update from the register file."""
        for address in SAVED:
            self._content[address] = (values[address], values[address + 1])
        self.count = (self.count + 1) & 0xFFFF
        self.corrupt = False

    def break_off(self) -> None:
        """The supply went during an update."""
        self.count = (self.count + 1) & 0xFFFF
        self.corrupt = True
