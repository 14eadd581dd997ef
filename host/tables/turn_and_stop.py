"""The document's drift test: turn fast, stop at yaw +25.8°, and watch the angles for 30 s (section 5.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.tables.angle_errors import wrapped
from host.tables.board_run import STILL_S, run_board, sensor
from host.tables.document import DocumentDrift, document_drift
from host.tables.positions import FAST_TURN_S, drift_scenario

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class StopDrift:
    """What came of the rest behind the stop, for several specimens of the sensor."""

    document: DocumentDrift
    arithmetic: str
    compensated: bool
    seeds: tuple[int, ...]
    largest_deg: Array
    """(seeds, 3) pitch, roll, yaw: the largest error in the rest."""
    times_s: Array
    error_deg: Array
    """(n, 3) of the first seed, against the time since the stop."""

    @property
    def rms_deg(self) -> tuple[float, float, float]:
        """Over the seeds."""
        pitch, roll, yaw = np.sqrt(np.mean(self.largest_deg**2, axis=0)).tolist()
        return pitch, roll, yaw

    @property
    def worst_deg(self) -> tuple[float, float, float]:
        """Over the seeds."""
        pitch, roll, yaw = np.max(self.largest_deg, axis=0).tolist()
        return pitch, roll, yaw

    @property
    def met(self) -> bool | None:
        """Whether every seed drifts less than the document, axis by axis; None: without compensation."""
        if not self.compensated:
            return None
        return bool(np.all(self.largest_deg < np.array(self.document.drift_deg)))


def stop_drift(arithmetic: str, seeds: tuple[int, ...], compensated: bool) -> StopDrift:
    """The test with each seed. Raises UserError."""
    document = document_drift()
    scenario = drift_scenario(document.yaw_deg, document.after_s, STILL_S, imu=sensor())
    stop_s = STILL_S + FAST_TURN_S
    courses: list[Array] = []
    times: list[Array] = []
    for seed in seeds:
        told = run_board(scenario, arithmetic, seed, drift_compensation=compensated).after(stop_s)
        times.append(told.times_s - stop_s)
        courses.append(np.degrees(wrapped(told.measured - told.truth)))
    largest = np.array([np.max(np.abs(course), axis=0) for course in courses])
    return StopDrift(document, arithmetic, compensated, seeds, largest, times[0], courses[0])
