"""CSV: NAME.csv with inertial samples and truth side by side, NAME.gnss.csv with the
receiver's epochs, NAME.mag.csv, NAME.baro.csv and NAME.baseline.csv."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.record.row_text import RowText
from host.simulate.formats.side_csv import SideCsv
from host.simulate.part_files import PartFiles
from host.simulate.rows import GNSS, TRUTH, imu_rows, imu_table, truth_rows
from host.simulate.source import Source
from host.simulate.stream import Block


class CsvWriter:
    """Writes the files."""

    def __init__(self, source: Source, path: Path, files: PartFiles, about: Mapping[str, Any]) -> None:
        imu = imu_table(source.convention)
        columns = (*imu.columns, *(f"true_{name}" for name in TRUTH.columns))
        self._samples = files.open(path)
        self._samples.write(",".join(columns).encode() + b"\n")
        self._text = RowText.csv((*imu.decimals, *TRUTH.decimals))
        self._gnss = files.open(path.with_suffix(".gnss.csv")) if source.epochs else None
        if self._gnss is not None:
            self._gnss.write(",".join(GNSS.columns).encode() + b"\n")
        self._sides = SideCsv(source, path, files)
        self._gnss_text = RowText.csv(GNSS.decimals)

    def add_block(self, block: Block) -> None:
        """A line a sample."""
        self._samples.write(self._text.text(np.hstack((imu_rows(block), truth_rows(block)))))

    def add_gnss(self, rows: NDArray[np.float64]) -> None:
        """A line an epoch."""
        if self._gnss is not None:
            self._gnss.write(self._gnss_text.text(rows))

    def add_side(self, name: str, rows: NDArray[np.float64]) -> None:
        """A line a sample."""
        self._sides.add(name, rows)

    def finish(self) -> None:
        """Nothing is left to write."""
