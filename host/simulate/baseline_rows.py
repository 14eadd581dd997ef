"""The baseline of two antennas as rows of printable numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import GnssEpoch
from host.record.tables import Table
from host.simulate.instants import NS

Floats = NDArray[np.float64]
DEGREES = 180.0 / math.pi

BASELINE_NAME = "baseline"
BASELINE = Table(
    (
        *("t_s", "fix", "heading_deg", "pitch_deg", "length_m"),
        *("heading_acc_deg", "pitch_acc_deg", "length_acc_m"),
        *("true_heading_deg", "true_pitch_deg", "true_length_m"),
    ),
    (9, 0, 4, 4, 4, 4, 4, 4, 6, 6, 6),
)
FIXES = {"NONE": 0.0, "FLOAT": 1.0, "FIXED": 2.0}
"""How the ambiguities stand, as the column `fix` tells it."""


def baseline_rows(epochs: Iterable[tuple[int, GnssEpoch]], true_ned: Floats) -> Floats:
    """Rows of BASELINE beside the true vector (n, 3), north, east, down in m; NaN without a solution."""
    rows = []
    for (time_ns, epoch), vector in zip(epochs, true_ned.tolist(), strict=True):
        level = math.hypot(vector[0], vector[1])
        truth = (
            math.atan2(vector[1], vector[0]) * DEGREES % 360.0,
            math.atan2(-vector[2], level) * DEGREES,
            math.hypot(level, vector[2]),
        )
        rows.append((time_ns / NS, *_solution(epoch), *truth))
    return np.array(rows, dtype=np.float64).reshape(-1, len(BASELINE.columns))


def _solution(epoch: GnssEpoch) -> tuple[float, ...]:
    solution = epoch.baseline
    if solution is None or solution.fix == "NONE":
        return (FIXES["NONE"], *(math.nan,) * 6)
    return (
        FIXES[solution.fix],
        *(solution.heading * DEGREES, solution.pitch * DEGREES, solution.length),
        *(solution.heading_acc * DEGREES, solution.pitch_acc * DEGREES, solution.length_acc),
    )
