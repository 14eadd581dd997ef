"""One sub-filter's sensor fails for 60 s on the board: chapter5 with faults at wires, chips and signals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from host.record.result import RunRequest, RunResult
from host.report.numbers import NONE, number
from host.report.summary import MET, NOT_MET, Section
from host.run.runner import run
from host.tables.federated_rows import BOUNDED_DEG, BOUNDED_M, RECOVERED_WITHIN_S

BOARD, SCENARIO, PROFILE = "gfsins", "chapter5", "equivalent"
BEGIN_S, LENGTH_S, DRIVE_S = 120.0, 60.0, 240
FILTERS = ("compass", "GPS")
FAULTS = (
    ("compass does not answer", 0, "i2c-nack", "compass", ""),
    ("compass repeats itself", 0, "sensor-frozen", "U8", ""),
    ("compass turned by iron", 0, "sensor-stuck", "U8", '{ quantity = "mag", axis = "y", value = 5e-6 }'),
    ("GPS silent", 1, "uart-cut", "gnss", ""),
    ("GPS 300 m off", 1, "gnss-position-jump", "U9", "{ north_m = 300.0 }"),
)
"""Name, the filter that loses by it, kind, target, parameters."""


@dataclass(frozen=True, slots=True)
class BoardFailureRow:
    """One failure."""

    name: str
    cause: str
    detected_s: float | None
    """After it began; None: never."""
    recovered_s: float | None
    """After it ended."""
    worst_position_m: float
    """Horizontal, from the beginning of the failure to the end of the run."""
    worst_heading_deg: float

    @property
    def met(self) -> bool:
        """Detected, isolated, recovered, the rest in bounds."""
        if self.detected_s is None or self.recovered_s is None or self.recovered_s > RECOVERED_WITHIN_S:
            return False
        return self.worst_position_m < BOUNDED_M and self.worst_heading_deg < BOUNDED_DEG


def board_failure_rows(seed: int) -> Iterator[BoardFailureRow]:
    """Each failure on a drive of its own."""
    for name, which, kind, target, parameters in FAULTS:
        more = f", parameters = {parameters}" if parameters else ""
        fault = f'{{kind = "{kind}", target = "{target}", at_s = {BEGIN_S}, duration_s = {LENGTH_S}{more}}}'
        changed = (f"fault=[{fault}]", f"duration_s={DRIVE_S}", "expect={}")
        asked = RunRequest(BOARD, SCENARIO, profile=PROFILE, seed=seed, capture=False, overrides=changed)
        yield _row(name, FILTERS[which], run(asked))


def _row(name: str, which: str, result: RunResult) -> BoardFailureRow:
    assert result.data is not None
    isolated, trusted = f"{which} filter isolated: ", f"{which} filter trusted again"
    told = [(event.at_s, event.text) for event in result.events if event.source == "board"]
    cut = [
        (at, text.removeprefix(isolated)) for at, text in told if text.startswith(isolated) and at > BEGIN_S
    ]
    end_s = BEGIN_S + LENGTH_S
    again = [at for at, text in told if text == trusted and at > end_s]
    series = result.data.solution
    late = series.column("t_s") > BEGIN_S
    position = np.hypot(series.column("error_north_m")[late], series.column("error_east_m")[late])
    return BoardFailureRow(
        name,
        cut[0][1] if cut else NONE,
        cut[0][0] - BEGIN_S if cut else None,
        again[-1] - end_s if again else None,
        float(np.max(position)),
        float(np.max(np.abs(series.column("error_yaw_deg")[late]))),
    )


def section(rows: list[BoardFailureRow]) -> Section:
    """One row a failure."""
    cells = [
        (
            row.name,
            row.cause,
            NONE if row.detected_s is None else number(row.detected_s),
            NONE if row.recovered_s is None else number(row.recovered_s),
            number(row.worst_position_m),
            f"{row.worst_heading_deg:.3f}",
            MET if row.met else NOT_MET,
        )
        for row in rows
    ]
    columns = (
        "for 60 s", "seen as", "isolated after, s", "trusted again after, s", "worst position, m",
        "worst heading, °", "verdict",
    )  # fmt: skip
    note = "The board on scenario chapter5, fusion-feedback: its words and its solution."
    return Section("One sub-filter's sensor fails, on the board", columns, tuple(cells), 2, note)


def to_dict(row: BoardFailureRow) -> dict[str, Any]:
    """For JSON."""
    return {
        "failure": row.name,
        "seen_as": row.cause,
        "isolated_after_s": row.detected_s,
        "trusted_after_s": row.recovered_s,
        "worst_position_m": row.worst_position_m,
        "worst_heading_deg": row.worst_heading_deg,
        "met": row.met,
    }
