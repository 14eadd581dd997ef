"""What every format does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from host.simulate.part_files import PartFiles
from host.simulate.source import Source
from host.simulate.stream import Block


class Writer(Protocol):
    """Begun with the drive; blocks and rows of `host.simulate.rows.GNSS` come in the order of time."""

    def __init__(self, source: Source, path: Path, files: PartFiles, about: Mapping[str, Any]) -> None:
        """`about`: what made this, as JSON holds it."""
        ...

    def add_block(self, block: Block) -> None:
        """Inertial samples with their truth."""
        ...

    def add_gnss(self, rows: NDArray[np.float64]) -> None:
        """Receiver epochs."""
        ...

    def add_side(self, name: str, rows: NDArray[np.float64]) -> None:
        """Rows of one of the source's side tables, by its name."""
        ...

    def finish(self) -> None:
        """All has come."""
        ...
