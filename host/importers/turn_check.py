"""Whether the vehicle turns as its course does: rates in a wrong unit or about a wrong axis show in bends.

The angle about the down axis, integrated between receiver epochs, is held against the change of the course
over ground (or the reference's, without a receiver). Slow cars never turn at 50 rad/s, whatever the unit.
"""

from __future__ import annotations

import math
from array import array

import numpy as np

from host.importers.findings import Findings, Kind
from host.importers.series import Floats, Rows, Series
from host.importers.time_base import NS
from host.importers.topics import RATES, VELOCITY
from host.importers.unit_checks import AGREE, refuse
from host.importers.units import QUANTITIES

EACH_S, ANGLE_EACH_S = 0.9, 0.3
LONGEST_STEP_S = 2.5
LONGEST_SAMPLE_STEP_S = 0.5
LEAST_SPEED_MPS = 3.0
LEAST_TURNS = 10
LEAST_TURN_DEG = 1.0
"""RMS change of course over a step, below which nothing is judged."""
BELIEVED, DISBELIEVED = 0.9, 0.3
"""Correlations."""


class TurnCheck:
    """Follows the first inertial series, and the first one that tells a course."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._imu: Series | None = None
        self._course: Series | None = None
        self._angle_deg = 0.0
        self._last: tuple[float, float] | None = None
        self._angles = array("d")
        self._courses = array("d")
        """Pairs of time and angle."""
        self._place = 0

    def take(self, rows: Rows) -> None:
        """Sound rows of any series."""
        columns = set(rows.series.table.columns)
        if columns >= set(RATES) and self._imu in (None, rows.series):
            if self._imu is None:
                self._imu, self._place = rows.series, int(rows.places[0])
            self._integrate(rows)
        elif columns >= set(VELOCITY) and self._course in (None, rows.series):
            self._follow(rows)

    def finish(self) -> None:
        """Judge. Raises UnitRefusedError."""
        unit = None if self._imu is None else self._imu.units.get("gyro")
        if self._imu is None or unit is None:
            return
        turned, felt = self._steps()
        if len(turned) < LEAST_TURNS:
            return
        # A drive with few bends shows the gyro's bias, a steady circle has no spread.
        if float(np.std(turned)) > LEAST_TURN_DEG:
            turned, felt = turned - turned.mean(), felt - felt.mean()
        if float(np.sqrt(np.mean(turned**2))) < LEAST_TURN_DEG:
            return
        size = float(felt @ felt)
        correlation = float(turned @ felt) / math.sqrt(max(size * float(turned @ turned), 1e-30))
        place = self._imu.place(self._place)
        if abs(correlation) < DISBELIEVED:
            self._doubt(
                place, "the rate about the down axis does not follow the course: other axes, or another clock"
            )
        if abs(correlation) < BELIEVED:
            return
        ratio = float(turned @ felt) / size
        for name, factor in QUANTITIES["gyro"].items():
            if name != unit.name and abs(ratio / (factor / unit.factor) - 1.0) < 2 * AGREE:
                what = f"the course turns {ratio:.4g} times as fast as the gyro says"
                refuse(self._findings, self._imu, unit, place, what, name)
        if ratio < 0.0:
            self._doubt(
                place, f"the course turns {ratio:.3g} times as fast as the gyro says: its z axis points up"
            )

    def _doubt(self, place: str, what: str) -> None:
        assert self._imu is not None
        text = "axes are forward, right, down; taken as they are"
        self._findings.note(
            Kind.DOUBTFUL_UNIT, self._imu.file, f"{self._imu.topic} axes", [(place, what)], text=text
        )

    def _integrate(self, rows: Rows) -> None:
        times = rows.times_ns / NS
        rates = rows.values[:, rows.series.columns(RATES[2])[0]]
        if self._last is not None:
            times, rates = np.append(self._last[0], times), np.append(self._last[1], rates)
        self._last = float(times[-1]), float(rates[-1])
        steps = np.diff(times)
        steps[steps > LONGEST_SAMPLE_STEP_S] = 0.0
        angles = self._angle_deg + np.cumsum(0.5 * (rates[1:] + rates[:-1]) * steps)
        if not len(angles):
            return
        self._angle_deg = float(angles[-1])
        due = times[1:] >= (self._angles[-2] + ANGLE_EACH_S if self._angles else -np.inf)
        for t, angle in zip(times[1:][due].tolist(), angles[due].tolist(), strict=True):
            if not self._angles or t - self._angles[-2] >= ANGLE_EACH_S:
                self._angles.extend((t, angle))

    def _follow(self, rows: Rows) -> None:
        north, east, _ = rows.values[:, rows.series.columns(*VELOCITY)].T
        fast = np.hypot(north, east) > LEAST_SPEED_MPS
        if fast.any():
            self._course = rows.series
        courses = np.degrees(np.arctan2(east, north))
        for t, course in zip((rows.times_ns[fast] / NS).tolist(), courses[fast].tolist(), strict=True):
            if not self._courses or t - self._courses[-2] >= EACH_S:
                self._courses.extend((t, course))

    def _steps(self) -> tuple[Floats, Floats]:
        """Changes of course and of the gyro's angle, °, between neighbouring courses."""
        if len(self._courses) < 4 or len(self._angles) < 4:
            return np.empty(0), np.empty(0)
        t, course = np.array(self._courses).reshape(-1, 2).T
        when, angle = np.array(self._angles).reshape(-1, 2).T
        turned = (np.diff(course) + 180.0) % 360.0 - 180.0
        felt = np.diff(np.interp(t, when, angle))
        close = (np.diff(t) < LONGEST_STEP_S) & (t[:-1] >= when[0]) & (t[1:] <= when[-1])
        return turned[close], felt[close]
