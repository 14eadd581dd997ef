"""The host port of a recorded run, decoded with what decodes it while a run is on (`host.run.intake`).

Rows that are in the capture already are left out, so that what is given continues it.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from hal.emulated.virtual_time import SECOND
from host.capture.row_messages import RowMessages, event_message
from host.capture.topics import EVENTS
from host.record.recorder import Thinning
from host.record.run_data import BiasEstimate, GnssBatch, Innovation, MotionBatch, SolutionBatch
from host.record.tables import bias_rows, filter_rows, gnss_rows, innovation_rows, solution_rows
from host.recovery.recorded_run import RecordedRun
from host.recovery.tail import Tail
from host.run.intake import LinkIntake
from host.score.errors import solution_errors
from host.score.scorer import Scorer

Floats = NDArray[np.float64]


def decoded_anew(tail: Tail, run: RecordedRun) -> list[RowMessage]:
    """The messages that are missing, in the order of time of each topic."""
    rows = MissingRows(tail)
    clock = _Clock()
    intake = LinkIntake(clock.virtual_ns, run.truth, rows, run.receiver, run.installation)
    pieces = tail.pieces()
    resets = [one for one in tail.clocks() if one["processor"] == run.processor]
    for place, reset in enumerate(resets):
        clock.reset_ns, clock.rate = reset["reset_ns"], SECOND + reset["rate_ppb"]
        until_ns = resets[place + 1]["reset_ns"] if place + 1 < len(resets) else tail.mark_ns
        count = sum(end_ns <= until_ns for _data, end_ns in pieces)
        if count:
            intake.receive(pieces[:count])
            intake.flush()
            pieces = pieces[count:]
    return rows.messages()


class _Clock:
    """A processor's, as `hal.emulated.cpu` reads it."""

    reset_ns = 0
    rate = SECOND

    def virtual_ns(self, clock_ns: int) -> int:
        """The virtual time at which it showed `clock_ns`."""
        return self.reset_ns + clock_ns * SECOND // self.rate


RowMessage = tuple[str, int, bytes]
"""Topic, time in ns, text."""


class MissingRows:
    """Implements `host.run.intake.Takes`: rows and texts behind those that the capture has."""

    def __init__(self, tail: Tail) -> None:
        self._last_ns = tail.last_ns
        self._said: Counter[tuple[int, str]] = tail.texts()
        self._scorer = Scorer()
        self._thinning = Thinning()
        self._row_messages = RowMessages()
        self._innovations: list[Innovation] = []
        self._biases: list[BiasEstimate] = []
        self._found: list[RowMessage] = []

    def add_solution(self, solution: SolutionBatch, truth: MotionBatch) -> None:
        """Solutions with the truth at the same instants."""
        rows = solution_rows(solution, self._scorer.add_solution(solution, truth))
        self._rows("/solution", self._thinning.thinned(rows))

    def add_gnss(self, epochs: GnssBatch, truth: MotionBatch) -> None:
        """Receiver epochs, with the truth at the antenna."""
        self._rows("/gnss", gnss_rows(epochs, self._scorer.add_gnss(epochs, truth)))

    def add_covariance(self, t: float, covariance: Floats) -> None:
        """No topic of its own."""

    def add_innovation(self, innovation: Innovation) -> None:
        """Innovations of one GNSS update."""
        self._innovations.append(innovation)

    def add_bias(self, bias: BiasEstimate) -> None:
        """Slow filter states."""
        self._biases.append(bias)

    def add_status(self, rows: Floats) -> None:
        """No topic of its own."""

    def add_sensor(self, rows: Floats) -> None:
        """The health of the inertial sensor."""
        self._rows("/sensor", rows)

    def add_filters(self, which: Floats, status: Floats, solution: SolutionBatch, truth: MotionBatch) -> None:
        """What filters side by side take for the state."""
        self._rows("/filter", filter_rows(which, status, solution, solution_errors(solution, truth)))

    def add_event(self, t_ns: int, source: str, text: str) -> None:
        """Something that the board said."""
        if self._said[t_ns, text]:
            self._said[t_ns, text] -= 1
        else:
            self._found.append((EVENTS[0], t_ns, event_message(t_ns, source, text)))

    def messages(self) -> list[RowMessage]:
        """All that was missing."""
        if self._innovations:
            self._rows("/innovation", innovation_rows(self._innovations))
        if self._biases:
            self._rows("/bias", bias_rows(self._biases))
        return self._found

    def _rows(self, topic: str, rows: Floats) -> None:
        for place, times_ns, texts in self._row_messages.of(topic, rows):
            last_ns = self._last_ns.get(place, -1)
            told = zip(times_ns, texts, strict=True)
            self._found += [(place, t_ns, text) for t_ns, text in told if t_ns > last_ns]
