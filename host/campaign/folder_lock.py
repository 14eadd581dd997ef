"""One process at a time writes a campaign's folder."""

from __future__ import annotations

import os
from pathlib import Path

from host.record.errors import UserError

LOCK = "campaign.lock"
"""Never removed: a lock on a file that is no longer there keeps nobody out."""


class FolderLock:
    """Held until `release`, or until its process ends. Raises UserError when another process holds it."""

    def __init__(self, folder: Path) -> None:
        self._file: int | None = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            import fcntl
        except ImportError:  # not a POSIX system
            return
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.release()
            raise UserError(f"--out {folder}: another campaign is writing there; wait for it") from None

    def release(self) -> None:
        """Let others in."""
        if self._file is not None:
            os.close(self._file)
            self._file = None
