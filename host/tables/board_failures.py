"""One sub-filter's sensor fails for 60 s on the board: chapter5 with faults at wires, chips and signals."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from host.record.result import RunRequest, RunResult
from host.report.numbers import NONE
from host.run.runner import run
from host.tables.sensor_failure import SensorFailure

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


def board_failure_rows(seed: int) -> Iterator[SensorFailure]:
    """Each failure on a drive of its own."""
    for name, which, kind, target, parameters in FAULTS:
        more = f", parameters = {parameters}" if parameters else ""
        fault = f'{{kind = "{kind}", target = "{target}", at_s = {BEGIN_S}, duration_s = {LENGTH_S}{more}}}'
        changed = (f"fault=[{fault}]", f"duration_s={DRIVE_S}", "expect={}")
        asked = RunRequest(BOARD, SCENARIO, profile=PROFILE, seed=seed, capture=False, overrides=changed)
        yield _row(name, FILTERS[which], run(asked))


def _row(name: str, which: str, result: RunResult) -> SensorFailure:
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
    return SensorFailure(
        name=name,
        cause=cut[0][1] if cut else NONE,
        detected_s=cut[0][0] - BEGIN_S if cut else None,
        recovered_s=again[-1] - end_s if again else None,
        worst_position_m=float(np.max(position)),
        worst_heading_deg=float(np.max(np.abs(series.column("error_yaw_deg")[late]))),
    )
