"""Independent watchdog: resets the processor when it is not kicked in time."""

from typing import Protocol


class Watchdog(Protocol):
    """Once started it cannot be stopped."""

    def start(self, timeout_ns: int) -> None:
        """Arm with this timeout."""
        ...

    def kick(self) -> None:
        """Restart the timeout."""
        ...
