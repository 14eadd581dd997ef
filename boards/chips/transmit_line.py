"""What the receiver's TXD pin is wired to: a wire that carries bytes in order at its own baud rate."""

from typing import Protocol


class TransmitLine(Protocol):
    """One direction of a serial line, seen from its transmitter."""

    def send(self, data: bytes) -> int:
        """Queue `data` behind what is still being sent; the line works it off at its baud rate."""
        ...

    def set_baud(self, baud: int) -> None:
        """Change the bit rate of the bytes that follow."""
        ...
