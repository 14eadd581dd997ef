r"""Packets from one processor to another: SPI with DMA at both ends, sent here, received there.

    CS    ‾‾\__________________________________/‾‾‾    low for one packet
    SCLK  ---|16 bits|16 bits| … |16 bits|--------     words, most significant bit first
    DMA      from memory, the processor works on   ──► into memory there, interrupt when a packet is whole

The sender's processor hands a packet over and goes on. The receiver counts words, not chip selects: after a
word too few or too many its packets begin in the wrong place until it begins anew. What a packet holds, and
how a wrong one shows, is the programs' business.
"""

from typing import Protocol

from hal.interrupts import InterruptLine


class PacketSender(Protocol):
    """The master's end."""

    def send(self, data: bytes) -> bool:
        """Begin to send whole words by DMA; False: the packet before is still under way, nothing is sent.

        Raises ValueError for parts of words and for nothing.
        """
        ...


class PacketReceiver(Protocol):
    """The slave's end."""

    def begin(self, ring: bytearray, packet_bytes: int, line: InterruptLine) -> None:
        """Receive into `ring` (whole packets) by circular DMA from its first byte on, beginning with the next
        packet that is sent; pend `line` whenever `packet_bytes` have come. Raises ValueError when the ring
        does not hold whole packets, or a packet no whole words."""
        ...

    def received(self) -> int:
        """Bytes put into the ring since `begin`, never wrapped."""
        ...
