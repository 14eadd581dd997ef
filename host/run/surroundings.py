"""What the assembled board is put into: the simulated or recorded world, and a place for its log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from boards.chips.world import GnssWorld, ImuWorld
from boards.description import Chip
from host.sim.world import World


class Surroundings:
    """Implements `boards.assembly.Surroundings` on a `World`."""

    def __init__(self, world: World, log_dir: Path | None) -> None:
        self.world = world
        self._log_dir = log_dir
        self._files: list[BinaryIO] = []

    def imu(self, refdes: str, chip: Chip) -> ImuWorld:
        """Motion and errors of one inertial chip."""
        return self.world.imu(refdes, np.array(chip.mounting), np.array(chip.lever_arm_m), chip.errors)

    def gnss(self, refdes: str, chip: Chip) -> GnssWorld:
        """Satellites and errors of one receiver."""
        return self.world.gnss(refdes, np.array(chip.lever_arm_m))

    def log_sink(self, name: str) -> Callable[[bytes], None]:
        """A file of that name in the output folder, or nowhere when there is none."""
        if self._log_dir is None:
            return _drop
        self._log_dir.mkdir(parents=True, exist_ok=True)
        file = (self._log_dir / f"{name}.bin").open("wb")
        self._files.append(file)
        return lambda block: _write(file, block)

    def close(self) -> None:
        """Close the log files."""
        for file in self._files:
            file.close()


def _drop(_block: bytes) -> None:
    pass


def _write(file: BinaryIO, block: bytes) -> None:
    file.write(block)
