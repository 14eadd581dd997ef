"""Faults of chips behind chip selects: one whose answers no longer change, two with each other's wires."""

from __future__ import annotations

from hal.emulated.faults.spi import SpiFault
from hal.emulated.spi import Bytes, EmulatedSpiDevice
from hal.emulated.virtual_time import FAR


class SpiFrozenAnswers(SpiFault):
    """What the chip says never changes: every request gets the answer that it got first while the fault is at
    work, count and data of a FIFO too. The chip hears. `fired`: answers that were old."""

    def __init__(self, start_ns: int, end_ns: int = FAR) -> None:
        super().__init__(start_ns, end_ns)
        self._answers: dict[bytes, bytes] = {}

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """The first answer to this request."""
        request = bytes(mosi)
        answer = bytes(self.inner.transaction(mosi, start_ns, end_ns))
        first = self._answers.get(request)
        if first is None:
            self._answers[request] = answer
            return answer
        self.fired += 1
        return first


class SpiSwappedChips(SpiFault):
    """Two chips have each other's wires: this is one of the two ends. `fired`: transactions of this end."""

    other: SpiSwappedChips

    def install_with(
        self, device: EmulatedSpiDevice, partner: EmulatedSpiDevice, other: SpiSwappedChips
    ) -> None:
        """Exchange the chips of two chip selects; `other` is the end at `partner`."""
        if device is partner:
            raise ValueError(f"{device.name!r} cannot be exchanged with itself")
        self.other, other.other = other, self
        self.install(device)
        other.install(partner)

    def transaction(self, mosi: Bytes, start_ns: int, end_ns: int) -> Bytes:
        """With the chip of the other."""
        self.fired += 1
        return self.other.inner.transaction(mosi, start_ns, end_ns)
