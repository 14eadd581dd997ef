"""NPZ for NumPy: `imu` (samples with their truth, a structured array), `gnss`, `mag`, `baro`, and `about`
(JSON).

    data = np.load("drive.npz")
    data["imu"]["force"], data["imu"]["rate"]      # (n, 3) m/s², rad/s in sensor axes
    data["imu"]["latitude"], data["gnss"]["height_m"]

An archive member is written as it comes; that of the receiver is kept meanwhile (a row an epoch).
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

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


class NpzWriter:
    """Writes the file."""

    def __init__(self, source: Source, path: Path, files: PartFiles, about: Mapping[str, Any]) -> None:
        self._about = about
        self._dtype = imu_dtype(source.convention)
        self._force, self._rate = self._dtype.names[1:3] if self._dtype.names else ("", "")
        self._archive = _Archive(files.open(path), "w", zipfile.ZIP_STORED, allowZip64=True)
        self._member = self._open("imu", self._dtype, (source.samples,))
        self._gnss: list[NDArray[np.float64]] = []
        self._ambients: dict[str, list[NDArray[np.float64]]] = {
            one.sensor.name: [] for one in source.ambients
        }
        self._columns = {one.sensor.name: one.sensor.table.columns for one in source.ambients}

    def add_block(self, block: Block) -> None:
        """Records of all samples."""
        rows, records = block.truth, np.empty(len(block.truth), self._dtype)
        records["t_ns"] = block.times_ns
        records[self._force], records[self._rate] = block.felt[:, :3], block.felt[:, 3:6]
        records["temperature_c"] = block.felt[:, 6]
        for name, column in (("latitude", LATITUDE), ("longitude", LONGITUDE), ("height", HEIGHT)):
            records[name] = rows[:, column]
        records["velocity"] = rows[:, VELOCITY : VELOCITY + 3]
        records["yaw"], records["pitch"], records["roll"] = euler_angles(rows[:, C_NB : C_NB + 9])
        self._member.write(records.view(np.uint8).data)

    def add_gnss(self, rows: NDArray[np.float64]) -> None:
        """Kept until the end."""
        self._gnss.append(rows)

    def add_ambient(self, name: str, rows: NDArray[np.float64]) -> None:
        """Kept until the end."""
        self._ambients[name].append(rows)

    def finish(self) -> None:
        """Write the other members."""
        self._member.close()
        self._rows("gnss", GNSS.columns, self._gnss)
        for name, parts in self._ambients.items():
            self._rows(name, self._columns[name], parts)
        self._whole("about", np.array(json.dumps(self._about)))
        self._archive.close()

    def _rows(self, name: str, columns: Sequence[str], parts: list[NDArray[np.float64]]) -> None:
        fields = [(column, "<f8") for column in columns]
        rows = np.vstack(parts) if parts else np.empty((0, len(fields)))
        self._whole(name, np.ascontiguousarray(rows).view(fields).reshape(-1))

    def _whole(self, name: str, array: NDArray[Any]) -> None:
        with self._open(name, array.dtype, array.shape) as member:
            member.write(array.tobytes())

    def _open(self, name: str, dtype: np.dtype[Any], shape: tuple[int, ...]) -> IO[bytes]:
        info = zipfile.ZipInfo(f"{name}.npy", BEGINNING)
        member = self._archive.open(info, "w", force_zip64=True)
        header = {"descr": npy.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        npy.write_array_header_2_0(member, header)
        return member
