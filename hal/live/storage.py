"""A log file in the computer's file system."""

from __future__ import annotations

import os
from pathlib import Path

from hal.live.cpu import LiveCpu


class LiveLogFile:
    """Implements `hal.storage.LogFile` on a file, which it appends to.

    The card is *missing* while the folder is not there or the file was deleted or its medium refuses it;
    every call tries again. `problem` tells the last failure in words, for people.
    """

    def __init__(self, cpu: LiveCpu, path: Path) -> None:
        self.path = path
        self.problem = ""
        self._cpu = cpu
        self._descriptor: int | None = None

    def append(self, data: bytes) -> bool:
        """Write `data` after what is there; False when the card is missing, full or failed."""
        self._cpu.safe_point()
        try:
            descriptor = self._open()
            length = os.fstat(descriptor).st_size
            try:
                left = memoryview(data)
                while left:
                    left = left[os.write(descriptor, left) :]
            except OSError:
                os.ftruncate(descriptor, length)  # all of it or nothing
                raise
        except OSError as error:
            return self._failed(error)
        return True

    def sync(self) -> bool:
        """Make what was appended survive a power cut; False when it could not."""
        self._cpu.safe_point()
        try:
            os.fsync(self._open())
        except OSError as error:
            return self._failed(error)
        return True

    def close(self) -> None:
        """Close the file; the next call opens it again."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def _open(self) -> int:
        if self._descriptor is not None and os.fstat(self._descriptor).st_nlink == 0:
            self.close()
            raise FileNotFoundError(f"{self.path} was deleted")
        if self._descriptor is None:
            self._descriptor = os.open(
                self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644
            )
        return self._descriptor

    def _failed(self, error: OSError) -> bool:
        self.problem = str(error)
        return False
