"""Faults on the wire of a packet link."""

from __future__ import annotations

from hal.emulated.faults.chance import BitErrors, Strikes
from hal.emulated.faults.fault import Fault
from hal.emulated.packet_link import WORD_BYTES, EmulatedPacketSender


class PacketFault(Fault):
    """Changes what arrives of what is sent."""

    def install(self, sender: EmulatedPacketSender) -> None:
        """Put the fault on the wire behind `sender` for its time."""

        def begin() -> None:
            sender.disturbances.append(self.disturb)

        def end() -> None:
            sender.disturbances.remove(self.disturb)

        self._schedule(sender.time, begin, end)

    def disturb(self, data: bytes) -> bytes:
        """What arrives of a packet."""
        raise NotImplementedError


class PacketLoss(PacketFault):
    """Packets do not arrive, with a probability each. `fired`: those lost."""

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._strikes = Strikes(probability, seed, f"{name}.loss")

    def disturb(self, data: bytes) -> bytes:
        """All of it, or nothing."""
        if not self._strikes.next():
            return data
        self.fired += 1
        return b""


class PacketBitErrors(PacketFault):
    """Every bit is flipped with a probability. `fired`: bits flipped."""

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._errors = BitErrors(probability, seed, f"{name}.bits")

    def disturb(self, data: bytes) -> bytes:
        """With errors."""
        disturbed, flipped = self._errors.disturb(data)
        self.fired += flipped
        return disturbed


class PacketWordSlip(PacketFault):
    """The receiver misses one word of a packet, with a probability each. `fired`: words missed."""

    def __init__(self, start_ns: int, end_ns: int, probability: float, seed: int, name: str) -> None:
        super().__init__(start_ns, end_ns)
        self._strikes = Strikes(probability, seed, f"{name}.slip")

    def disturb(self, data: bytes) -> bytes:
        """Without the word in its middle."""
        if not self._strikes.next():
            return data
        self.fired += 1
        middle = len(data) // (2 * WORD_BYTES) * WORD_BYTES
        return data[:middle] + data[middle + WORD_BYTES :]
