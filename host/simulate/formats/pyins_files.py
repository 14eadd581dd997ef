"""CSV as pyins reads it: NAME.imu.csv, NAME.truth.csv, NAME.gnss.csv, each indexed by `time` in s.

    imu = pd.read_csv("drive.imu.csv", index_col="time")
    strapdown.compute_increments_from_imu(imu, "rate")        # "increment" for increments

Columns are pyins' own: gyro_x … accel_z (rad/s and m/s², or rad and m/s); lat, lon, alt (°, m), VN, VE, VD,
roll, pitch, heading (°, −180 … 180).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.record.row_text import RowText
from host.simulate.formats.side_csv import SideCsv
from host.simulate.part_files import PartFiles
from host.simulate.rows import GNSS, truth_rows
from host.simulate.source import Source
from host.simulate.stream import NS, Block

IMU = ("time", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
PLACE, VELOCITY, ANGLES = ("lat", "lon", "alt"), ("VN", "VE", "VD"), ("roll", "pitch", "heading")
IMU_DECIMALS = (9, *(15,) * 3, *(12,) * 3)
TRUTH_DECIMALS = (9, 12, 12, 7, 9, 9, 9, 10, 10, 10)
GNSS_DECIMALS = (9, 12, 12, 4, 4, 4, 4)
_FIX = GNSS.columns.index("fix")
_SOLUTION = slice(GNSS.columns.index("latitude_deg"), GNSS.columns.index("v_down_mps") + 1)


class PyinsWriter:
    """Writes the files."""

    def __init__(self, source: Source, path: Path, files: PartFiles, about: Mapping[str, Any]) -> None:
        headers = {
            "imu": IMU,
            "truth": ("time", *PLACE, *VELOCITY, *ANGLES),
            "gnss": ("time", *PLACE, *VELOCITY),
        }
        self._sides = SideCsv(source, path, files)
        self._files = {kind: files.open(path.with_suffix(f".{kind}.csv")) for kind in headers}
        for kind, columns in headers.items():
            self._files[kind].write(",".join(columns).encode() + b"\n")
        decimals = {"imu": IMU_DECIMALS, "truth": TRUTH_DECIMALS, "gnss": GNSS_DECIMALS}
        self._text = {kind: RowText.csv(places) for kind, places in decimals.items()}

    def add_block(self, block: Block) -> None:
        """A line a sample in both files."""
        t_s = (block.times_ns / NS)[:, None]
        self._write("imu", np.hstack((t_s, block.felt[:, 3:6], block.felt[:, 0:3])))
        truth = truth_rows(block)
        heading = (truth[:, 6:7] + 180.0) % 360.0 - 180.0
        self._write("truth", np.hstack((t_s, truth[:, :6], truth[:, 8:9], truth[:, 7:8], heading)))

    def add_gnss(self, rows: NDArray[np.float64]) -> None:
        """A line an epoch with a fix."""
        fixed = rows[rows[:, _FIX] == 1.0]
        self._write("gnss", np.hstack((fixed[:, :1], fixed[:, _SOLUTION])))

    def add_side(self, name: str, rows: NDArray[np.float64]) -> None:
        """A line a sample, in a CSV of its own."""
        self._sides.add(name, rows)

    def finish(self) -> None:
        """Nothing is left to write."""

    def _write(self, kind: str, rows: NDArray[np.float64]) -> None:
        self._files[kind].write(self._text[kind].text(rows))
