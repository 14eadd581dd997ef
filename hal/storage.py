"""A block device with a file on it, as a logger uses an SD card."""

from typing import Protocol


class LogFile(Protocol):
    """An append-only file that survives a power cut up to the last `sync`."""

    def append(self, data: bytes) -> bool:
        """Write `data` after what is there; False when the card is missing, full or failed."""
        ...

    def sync(self) -> bool:
        """Make what was appended survive a power cut; False when it could not."""
        ...
