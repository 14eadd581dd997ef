"""CAN 2.0 controller, classic frames with 11- or 29-bit identifiers and 0 … 8 data bytes."""

from typing import NamedTuple, Protocol


class CanFrame(NamedTuple):
    """One data frame."""

    identifier: int
    data: bytes
    extended: bool = False


class CanController(Protocol):
    """One node on one bus."""

    def send(self, frames: tuple[CanFrame, ...]) -> int:
        """Queue frames in order and return how many were taken; the rest found the queue full."""
        ...

    def receive(self) -> CanFrame | None:
        """The oldest frame received, or None."""
        ...
