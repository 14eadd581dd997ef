"""Channels that stand still: the same value, bit for bit, for longer than a working sensor would give."""

from __future__ import annotations

import numpy as np

from host.importers.findings import Findings, Kind
from host.importers.series import Rows, Series
from host.importers.time_base import NS

LEAST_ROWS, LEAST_NS = 100, 2 * NS
"""A run of equal values shorter than one of these is nothing special."""


class Standstill:
    """Follows runs of equal values in the watched columns of one series."""

    def __init__(self, series: Series, findings: Findings) -> None:
        self._series = series
        self._findings = findings
        self._runs = [
            _Run(name, column)
            for name, column in zip(series.watched, series.columns(*series.watched), strict=True)
        ]

    def take(self, rows: Rows) -> None:
        """Further rows."""
        for run in self._runs:
            self._follow(run, rows)

    def finish(self) -> None:
        """The last runs have ended."""
        for run in self._runs:
            self._end(run)

    def _follow(self, run: _Run, rows: Rows) -> None:
        values = rows.values[:, run.column]
        changes = np.flatnonzero(np.diff(values, prepend=run.value) != 0.0)
        if not len(changes):
            run.rows += len(values)
            run.last_ns = int(rows.times_ns[-1])
            return
        first = int(changes[0])
        run.rows += first
        if first:
            run.last_ns = int(rows.times_ns[first - 1])
        self._end(run)
        edges = np.append(changes, len(values))
        is_long = np.diff(edges) >= LEAST_ROWS
        is_long[-1] = True  # it may go on in the next rows
        for begin, end in zip(edges[:-1][is_long].tolist(), edges[1:][is_long].tolist(), strict=True):
            run.value, run.rows = float(values[begin]), end - begin
            run.begin_ns, run.last_ns = int(rows.times_ns[begin]), int(rows.times_ns[end - 1])
            run.place = int(rows.places[begin])
            if end < len(values):
                self._end(run)

    def _end(self, run: _Run) -> None:
        if run.rows >= LEAST_ROWS and run.last_ns - run.begin_ns >= LEAST_NS:
            length = (run.last_ns - run.begin_ns) / NS
            case = (self._series.place(run.place), f"{run.value:.9g} for {length:.6g} s, {run.rows:,} rows")
            channel = f"{self._series.topic} {run.name}"
            self._findings.note(Kind.STUCK, self._series.file, channel, [case], text="kept")
        run.rows = 0


class _Run:
    """The run of equal values under way in one column."""

    def __init__(self, name: str, column: int) -> None:
        self.name = name
        self.column = column
        self.value = np.nan
        self.rows = 0
        self.begin_ns = 0
        self.last_ns = 0
        self.place = 0
