"""The figures of one group of epochs: RMS, maximum and 95 % of each kind of error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.score.statistic import Statistic

DEGREES = 180 / np.pi

QUANTITIES = {
    "position_horizontal": "m",
    "position_vertical": "m",
    "velocity": "mps",
    "velocity_horizontal": "mps",
    "roll": "deg",
    "pitch": "deg",
    "yaw": "deg",
}


class ErrorGroup:
    """Takes in error rows (columns as in `host.score.errors.COLUMNS`) and tells their figures."""

    def __init__(self, prefix: str = "", with_attitude: bool = True) -> None:
        self._prefix = prefix
        names = list(QUANTITIES) if with_attitude else list(QUANTITIES)[:4]
        self._statistics = {name: Statistic() for name in names}

    @property
    def count(self) -> int:
        """Epochs taken in."""
        return self._statistics["position_horizontal"].count

    def add(self, errors: NDArray[np.float64]) -> None:
        """Take in rows, shape (n, 12), or (n, 6) without attitude."""
        squares = errors[:, :6] * errors[:, :6]
        take = self._statistics
        take["position_horizontal"].add(np.sqrt(squares[:, 0] + squares[:, 1]))
        take["position_vertical"].add(np.abs(errors[:, 2]))
        horizontal = squares[:, 3] + squares[:, 4]
        take["velocity"].add(np.sqrt(horizontal + squares[:, 5]))
        take["velocity_horizontal"].add(np.sqrt(horizontal))
        for column, name in ((9, "roll"), (10, "pitch"), (11, "yaw")):
            if name in take:
                take[name].add(np.abs(errors[:, column]) * DEGREES)

    def figures(self) -> dict[str, float | None]:
        """`<quantity>_rms_<unit>`, `…_max_…` and `…_p95_…`; None where nothing was taken in."""
        found: dict[str, float | None] = {}
        for name, statistic in self._statistics.items():
            unit = QUANTITIES[name]
            found[f"{self._prefix}{name}_rms_{unit}"] = statistic.rms()
            found[f"{self._prefix}{name}_max_{unit}"] = statistic.max()
            found[f"{self._prefix}{name}_p95_{unit}"] = statistic.quantile(0.95)
        return found
