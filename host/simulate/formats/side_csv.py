"""NAME.mag.csv, NAME.baro.csv and NAME.baseline.csv beside a format's own files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.record.row_text import RowText
from host.simulate.part_files import PartFiles
from host.simulate.source import Source


class SideCsv:
    """Writes them for the side tables of a source."""

    def __init__(self, source: Source, path: Path, files: PartFiles) -> None:
        self._files = {}
        self._texts = {}
        for side in source.side_tables:
            name, table = side.name, side.table
            self._files[name] = files.open(path.with_suffix(f".{name}.csv"))
            self._files[name].write(",".join(table.columns).encode() + b"\n")
            self._texts[name] = RowText.csv(table.decimals)

    def add(self, name: str, rows: NDArray[np.float64]) -> None:
        """A line a sample."""
        self._files[name].write(self._texts[name].text(rows))
