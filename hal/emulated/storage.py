"""A log file on an SD card.

The file system keeps the last incomplete block in memory; each block that fills up is written at once and
takes its time. What was appended belongs to the file only when `sync` has written the incomplete block and
the file's length into the directory: a power cut, a reset and a card pulled out lose everything since the
last completed sync.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hal.emulated.cpu import EmulatedCpu


@dataclass(frozen=True)
class CardTiming:
    """An ordinary card on a four-bit bus: one block in 0.4 ms, i.e. 1.3 MB/s."""

    block_bytes: int = 512
    block_write_ns: int = 400_000
    directory_blocks: int = 2
    """Blocks that a sync writes besides the data: allocation table and directory entry."""


class EmulatedLogFile:
    """Implements `hal.storage.LogFile`. `sink` gets the bytes that have become safe, in order."""

    def __init__(
        self,
        cpu: EmulatedCpu,
        sink: Callable[[bytes], None],
        capacity_bytes: int = 16_000_000_000,
        timing: CardTiming | None = None,
    ) -> None:
        self.capacity_bytes = capacity_bytes
        self.timing = timing or CardTiming()
        self.failed = False
        """A card that refuses every write."""
        self.synced_bytes = 0
        self.lost_bytes = 0
        self._cpu = cpu
        self._sink = sink
        self._inserted = True
        self._unsynced: list[bytes] = []
        self._unsynced_bytes = 0
        self._losses = 0
        cpu.reset_hooks.append(self.power_cut)

    def append(self, data: bytes) -> bool:
        """Write `data` after what is there; False when the card is missing, full or failed."""
        if not self._usable or self.synced_bytes + self._unsynced_bytes + len(data) > self.capacity_bytes:
            return False
        block = self.timing.block_bytes
        at = self.synced_bytes + self._unsynced_bytes
        self._unsynced.append(bytes(data))
        self._unsynced_bytes += len(data)
        losses = self._losses
        self._write_blocks((at + len(data)) // block - at // block)
        return losses == self._losses and self._usable

    def sync(self) -> bool:
        """Make what was appended survive a power cut; False when it could not."""
        if not self._usable:
            return False
        pieces = len(self._unsynced)
        if not pieces:
            return True
        losses = self._losses
        incomplete = (self.synced_bytes + self._unsynced_bytes) % self.timing.block_bytes != 0
        self._write_blocks(incomplete + self.timing.directory_blocks)
        if losses != self._losses or not self._usable:
            return False
        safe = b"".join(self._unsynced[:pieces])
        del self._unsynced[:pieces]
        self._unsynced_bytes -= len(safe)
        self.synced_bytes += len(safe)
        self._sink(safe)
        return True

    def power_cut(self) -> None:
        """Lose what no completed sync has made safe."""
        self.lost_bytes += self._unsynced_bytes
        self._losses += 1
        self._unsynced.clear()
        self._unsynced_bytes = 0

    def remove(self) -> None:
        """Pull the card out."""
        self._inserted = False
        self.power_cut()

    def insert(self) -> None:
        """Put the card back; the file goes on behind what was safe."""
        self._inserted = True

    @property
    def _usable(self) -> bool:
        return self._inserted and not self.failed

    def _write_blocks(self, blocks: int) -> None:
        if blocks:
            self._cpu.wait_until(self._cpu.time.now + blocks * self.timing.block_write_ns)
