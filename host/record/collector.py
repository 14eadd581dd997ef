"""Bounded series of a run for the report, gathered as the run goes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.link.attitude_output import UNKNOWN_AGE
from host.record.run_data import (
    NAVIGATING,
    SENSOR_COLUMNS,
    GnssBatch,
    MotionBatch,
    RunData,
    SolutionBatch,
    TaskTrace,
)
from host.record.series import DecimatedSeries
from host.record.tables import BIAS, FILTER, GNSS, INNOVATION, SOLUTION
from host.score.errors import Place, position_error_ned

Floats = NDArray[np.float64]

PLACES = ("east_m", "north_m", "up_m")
TRUE_PLACES = ("true_east_m", "true_north_m", "true_up_m")

SOLUTION_LIMIT = 3072
SLOW_LIMIT = 1536
"""Rows of each series of the report: about as many as a screen has columns."""
AGES = slice(SENSOR_COLUMNS.index("age_least_us"), SENSOR_COLUMNS.index("age_most_us") + 1)


class Collector:
    """Takes in printable rows of a run and keeps evenly thinned series of them."""

    def __init__(self, outages: tuple[tuple[float, float], ...] = ()) -> None:
        self._origin: MotionBatch | None = None
        self.data = RunData(
            solution=DecimatedSeries((*SOLUTION.columns, *PLACES, *TRUE_PLACES), SOLUTION_LIMIT),
            gnss=DecimatedSeries((*GNSS.columns, *PLACES), SLOW_LIMIT),
            innovations=DecimatedSeries(INNOVATION.columns, SLOW_LIMIT),
            biases=DecimatedSeries(BIAS.columns, SLOW_LIMIT),
            outages=outages,
        )

    def add_solution(self, rows: Floats, solution: SolutionBatch, truth: MotionBatch) -> None:
        """Rows of the table SOLUTION with what they came from. Before alignment there is no place to show."""
        if len(rows):
            places = self._places(solution, truth)
            places[solution.mode < NAVIGATING] = np.nan
            self.data.solution.add(np.column_stack((rows, places, self._places(truth, truth))))

    def add_gnss(self, rows: Floats, epochs: GnssBatch, truth: MotionBatch) -> None:
        """Rows of the table GNSS with what they came from."""
        if len(rows):
            places = self._places(epochs, truth)
            places[~epochs.fix] = np.nan
            self.data.gnss.add(np.column_stack((rows, places)))

    def add_sensor(self, rows: Floats) -> None:
        """Rows of the table SENSOR."""
        shown = rows.copy()
        ages = shown[:, AGES]
        ages[ages == UNKNOWN_AGE] = np.nan
        self.data.sensor.add(shown)

    def add_filters(self, rows: Floats) -> None:
        """Rows of the table FILTER, of any filter."""
        for which in np.unique(rows[:, 1]).astype(int):
            while len(self.data.filters) <= which:
                self.data.filters.append(DecimatedSeries(FILTER.columns, SLOW_LIMIT))
            self.data.filters[which].add(rows[rows[:, 1] == which])

    def add_trace(self, trace: TaskTrace) -> None:
        """A recorded window of one processor."""
        self.data.traces.append(trace)

    def _places(self, points: Place, truth: MotionBatch) -> Floats:
        """East, north, up of `points` from the first true position, m, in its plane."""
        if self._origin is None:
            self._origin = truth
        count = len(points.latitude)
        origin = MotionBatch(
            *(np.repeat(getattr(self._origin, name)[:1], count, axis=0) for name in MotionBatch.__slots__)
        )
        ned = position_error_ned(points, origin)
        return np.column_stack((ned[:, 1], ned[:, 0], -ned[:, 2]))
