"""What the chip needs of the nets on INT1 and INT2."""

from __future__ import annotations

from typing import Protocol


class PinNet(Protocol):
    """What the chip needs of the net on one of its pins."""

    level: bool
    on_first_listener: object

    @property
    def listened(self) -> bool:
        """Whether anybody follows the level."""
        ...

    def set(self, level: bool) -> None:
        """Drive the level."""
        ...
