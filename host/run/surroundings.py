"""What the assembled board is put into: the simulated or recorded world, and a place for its log."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import CompassWorld, GnssEpoch, GnssWorld, ImuWorld, TenDofWorld
from boards.description import Board, Chip
from host.sim.gnss.glitched import GlitchedReceiver
from host.sim.gnss.schedule import Glitch
from host.sim.world import World

DAY_MS = 86_400_000
EPOCHS_REMEMBERED = 4096


@dataclass(frozen=True)
class Installation:
    """Where sensor and antenna sit on the vehicle, as the scorer needs it."""

    C_b_s: NDArray[np.float64]
    imu_lever_arm: NDArray[np.float64]
    """The navigation point: what the firmware computes is the motion of its sensor."""
    antenna_lever_arm: NDArray[np.float64]

    @classmethod
    def of(cls, board: Board) -> Installation:
        """That of a board: its first inertial chip and its first receiver."""
        chips = board.chips.values()
        imu = next((chip for chip in chips if chip.is_inertial), None)
        receiver = next((chip for chip in chips if chip.world == "gnss"), None)
        return cls(
            C_b_s=np.array(imu.mounting) if imu else np.eye(3),
            imu_lever_arm=np.array(imu.lever_arm_m) if imu else np.zeros(3),
            antenna_lever_arm=np.array(receiver.lever_arm_m) if receiver else np.zeros(3),
        )


class ReceiverSight:
    """A receiver's world that remembers when each epoch it gave was really valid."""

    def __init__(self, world: GnssWorld) -> None:
        self._world = world
        self._valid_ns: OrderedDict[int, list[int]] = OrderedDict()
        """By the time of day that epochs told: more than one where a fault has the receiver tell it twice."""

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The solution valid at `time_ns`."""
        epoch = self._world.epoch(time_ns)
        time_of_day_ms = round(epoch.gps_time_ns / 1e6) - epoch.leap_seconds * 1000
        self._valid_ns.setdefault(time_of_day_ms % DAY_MS, []).append(time_ns)
        if len(self._valid_ns) > EPOCHS_REMEMBERED:
            self._valid_ns.popitem(last=False)
        return epoch

    def strike(self, glitch: Glitch) -> None:
        """From now on the receiver reports wrongly while `glitch` lasts."""
        if not isinstance(self._world, GlitchedReceiver):
            self._world = GlitchedReceiver(self._world, [])
        self._world.glitches.append(glitch)

    def fired(self, fault_name: str) -> int:
        """How many epochs a fault of the receiver's own solution has struck."""
        glitches = getattr(self._world, "glitches", ())
        return sum(glitch.fired for glitch in glitches if glitch.name == fault_name)

    def validity_ns(
        self, time_of_day_ms: NDArray[np.float64], otherwise_ns: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """True validity of epochs told by their UTC time of day; `otherwise_ns`, where the board dated them,
        decides where that is not known, or known twice."""
        pairs = zip(time_of_day_ms.tolist(), otherwise_ns.tolist(), strict=True)
        return np.array([self._validity(int(ms), other) for ms, other in pairs], dtype=np.int64)

    def _validity(self, time_of_day_ms: int, otherwise_ns: int) -> int:
        known = self._valid_ns.get(time_of_day_ms, (otherwise_ns,))
        return min(known, key=lambda time_ns: abs(time_ns - otherwise_ns)) if len(known) > 1 else known[0]


class Surroundings:
    """Implements `boards.assembly.Surroundings` on a `World`."""

    def __init__(self, world: World, log_dir: Path | None) -> None:
        self.world = world
        self.sights: dict[str, ReceiverSight] = {}
        self._log_dir = log_dir
        self._files: list[BinaryIO] = []

    def imu(self, refdes: str, chip: Chip) -> ImuWorld:
        """Motion and errors of one inertial chip."""
        return self.world.imu(refdes, np.array(chip.mounting), np.array(chip.lever_arm_m), chip.errors)

    def gnss(self, refdes: str, chip: Chip) -> GnssWorld:
        """Satellites and errors of one receiver."""
        second = None if chip.second_antenna_m is None else np.array(chip.second_antenna_m)
        self.sights[refdes] = ReceiverSight(self.world.gnss(refdes, np.array(chip.lever_arm_m), second))
        return self.sights[refdes]

    def compass(self, refdes: str, chip: Chip) -> CompassWorld:
        """Force and magnetic field of one compass."""
        return self.world.compass(refdes, np.array(chip.mounting))

    def ten_dof(self, refdes: str, chip: Chip) -> TenDofWorld:
        """Motion, field and pressure of one chip that feels them all."""
        lever = np.array(chip.lever_arm_m)
        return self.world.ten_dof(refdes, np.array(chip.mounting), lever, chip.errors)

    def log_sink(self, name: str) -> Callable[[bytes], None]:
        """A file of that name in the output folder, or nowhere when there is none."""
        if self._log_dir is None:
            return _drop
        return LazyFile(self._log_dir / f"{name}.bin", self._files).write

    def close(self) -> None:
        """Close the log files."""
        for file in self._files:
            file.close()


def _drop(_block: bytes) -> None:
    pass


class LazyFile:
    """A file that is made when its first block comes."""

    def __init__(self, path: Path, opened: list[BinaryIO]) -> None:
        self._path = path
        self._opened = opened
        self._file: BinaryIO | None = None

    def write(self, block: bytes) -> None:
        """Append a block."""
        if self._file is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("wb")
            self._opened.append(self._file)
        self._file.write(block)
