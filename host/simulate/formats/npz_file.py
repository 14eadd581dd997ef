"""NPZ for NumPy: `imu` (samples with their truth, a structured array), `gnss`, `mag`, `baro`, and `about`
(JSON).

    data = np.load("drive.npz")
    data["imu"]["force"], data["imu"]["rate"]      # (n, 3) m/s², rad/s in sensor axes
    data["imu"]["latitude"], data["gnss"]["height_m"]

The samples are written as they come; the rows of the other members wait in nameless files beside it.
"""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from host.sim.earth import one_turn
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE, VELOCITY
from host.sim.truth import euler_angles
from host.simulate.part_files import PartFiles
from host.simulate.rows import GNSS
from host.simulate.source import Source
from host.simulate.stream import Block, Convention

BEGINNING = (1980, 1, 1, 0, 0, 0)
"""The archive's times: no wall clock, so that the same drive gives the same bytes."""


def imu_dtype(convention: Convention) -> np.dtype[Any]:
    """One sample: angles in rad, yaw 0 … 2π; velocity north, east, down."""
    increments = convention is Convention.INCREMENT
    force, rate = ("dv", "dtheta") if increments else ("force", "rate")
    return np.dtype(
        [
            ("t_ns", "<i8"),
            (force, "<f8", 3),
            (rate, "<f8", 3),
            ("temperature_c", "<f8"),
            ("latitude", "<f8"),
            ("longitude", "<f8"),
            ("height", "<f8"),
            ("velocity", "<f8", 3),
            ("yaw", "<f8"),
            ("pitch", "<f8"),
            ("roll", "<f8"),
        ]
    )


class _Archive(zipfile.ZipFile):
    """An archive that is left alone when it is given up."""

    def __del__(self) -> None:
        """Nothing is written into a file that was closed because the disk is full."""


class _Waiting:
    """Rows of a member whose turn comes after the samples."""

    def __init__(self, columns: Sequence[str], file: IO[bytes]) -> None:
        self.dtype = np.dtype([(column, "<f8") for column in columns])
        self.count = 0
        self._file = file

    def add(self, rows: NDArray[np.float64]) -> None:
        """More of them."""
        self.count += len(rows)
        self._file.write(np.ascontiguousarray(rows).tobytes())

    def move_to(self, member: IO[bytes]) -> None:
        """All of them into the archive."""
        self._file.seek(0)
        shutil.copyfileobj(self._file, member)


class NpzWriter:
    """Writes the file."""

    def __init__(self, source: Source, path: Path, files: PartFiles, about: Mapping[str, Any]) -> None:
        self._about = about
        self._dtype = imu_dtype(source.convention)
        self._force, self._rate = self._dtype.names[1:3] if self._dtype.names else ("", "")
        self._archive = _Archive(files.open(path), "w", zipfile.ZIP_STORED, allowZip64=True)
        self._member = self._open("imu", self._dtype, (source.samples,))
        tables = {"gnss": GNSS, **{one.name: one.table for one in source.side_tables}}
        self._waiting = {name: _Waiting(table.columns, files.aside(path)) for name, table in tables.items()}

    def add_block(self, block: Block) -> None:
        """Records of all samples."""
        rows, records = block.truth, np.empty(len(block.truth), self._dtype)
        records["t_ns"] = block.times_ns
        records[self._force], records[self._rate] = block.felt[:, :3], block.felt[:, 3:6]
        records["temperature_c"] = block.felt[:, 6]
        records["latitude"], records["height"] = rows[:, LATITUDE], rows[:, HEIGHT]
        records["longitude"] = one_turn(rows[:, LONGITUDE])
        records["velocity"] = rows[:, VELOCITY : VELOCITY + 3]
        records["yaw"], records["pitch"], records["roll"] = euler_angles(rows[:, C_NB : C_NB + 9])
        self._member.write(records.view(np.uint8).data)

    def add_gnss(self, rows: NDArray[np.float64]) -> None:
        """Kept aside until the end."""
        self._waiting["gnss"].add(rows)

    def add_side(self, name: str, rows: NDArray[np.float64]) -> None:
        """Kept aside until the end."""
        self._waiting[name].add(rows)

    def finish(self) -> None:
        """Write the other members."""
        self._member.close()
        for name, waiting in self._waiting.items():
            with self._open(name, waiting.dtype, (waiting.count,)) as member:
                waiting.move_to(member)
        about = np.array(json.dumps(self._about))
        with self._open("about", about.dtype, about.shape) as member:
            member.write(about.tobytes())
        self._archive.close()

    def _open(self, name: str, dtype: np.dtype[Any], shape: tuple[int, ...]) -> IO[bytes]:
        info = zipfile.ZipInfo(f"{name}.npy", BEGINNING)
        member = self._archive.open(info, "w", force_zip64=True)
        header = {"descr": npy.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        npy.write_array_header_2_0(member, header)
        return member
