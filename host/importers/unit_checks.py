"""Whether quantities can be in the units that the recording names.

What a vehicle or a hand can do bounds its measurements: no gyro here turns at 50 rad/s; a specific force has
the size of gravity most of the time; positions move with the velocity that is told beside them, and heights
with the climb. Certain contradictions refuse the import, unless the unit was stated for it; the others are
told.
"""

from __future__ import annotations

import math

import numpy as np

from host.importers.findings import Findings, Kind
from host.importers.series import Floats, Rows, Series
from host.importers.topics import FORCES, PLACE, RATES, VELOCITY
from host.importers.units import DEGREES, LENGTHS, QUANTITIES, Unit
from host.record.errors import UserError

MOST_RATE = 50.0
"""In rad/s, about what 2,865 °/s are; MEMS sensors end at 2,000 °/s."""
CERTAIN_CASES = 3
EARTH_M = 6_371_000.0
LEAST_STEPS = 10
LONGEST_STEP_S = 2.5
BELIEVED_CORRELATION = 0.8
AGREE = 0.15
"""Relative scatter within which a ratio is the one of two units."""


class UnitRefusedError(UserError):
    """A unit that is certainly another one."""


def refuse(findings: Findings, series: Series, unit: Unit, place: str, what: str, better: str) -> None:
    """Refuse a unit, or tell of it when it was stated or the format fixes it. Raises UnitRefusedError."""
    suggestion = f"it looks like {better}" if better else "no unit known here fits"
    if unit.stated:
        findings.note(
            Kind.DOUBTFUL_UNIT,
            series.file,
            f"{series.topic} {unit.quantity}",
            [(place, what)],
            text=f"{suggestion}; {unit.name} was stated and is believed",
        )
        return
    raise UnitRefusedError(
        f"{series.file}: {unit.quantity} is named {unit.name}, but {what}, first in {place}: {suggestion};"
        f" state the right one with --unit {unit.quantity}={better or unit.name} (the named one with"
        f" --unit {unit.quantity}={unit.name})"
    )


class InertialUnits:
    """Rates and specific forces of one inertial series."""

    def __init__(self, series: Series, findings: Findings) -> None:
        self._series = series
        self._findings = findings
        self._rates, self._forces = series.columns(*RATES), series.columns(*FORCES)
        self._too_fast = 0
        self._told_rate = False
        self._norms: list[float] = []

    def take(self, rows: Rows) -> None:
        """Sound rows."""
        unit = self._series.units.get("gyro")
        if unit is not None and not self._told_rate:
            self._check_rates(rows, unit)
        if len(rows):
            self._norms.append(float(np.median(np.linalg.norm(rows.values[:, self._forces], axis=1))))
            self._check_forces(rows)

    def finish(self) -> None:
        """Nothing more to come."""
        norm = float(np.median(self._norms)) if self._norms else math.nan
        if not 5.0 < norm < 20.0 and self._norms:
            self._findings.note(
                Kind.DOUBTFUL_UNIT,
                self._series.file,
                f"{self._series.topic} accel",
                [("the middle of all rows", f"{norm:.4g} m/s²")],
                text="a specific force holds gravity, about 9.8 m/s²; taken as it is",
            )

    def _check_rates(self, rows: Rows, unit: Unit) -> None:
        named = np.abs(rows.values[:, self._rates]).max(axis=1, initial=0.0) / unit.factor
        limit = MOST_RATE * (1.0 if unit.name == "rad/s" else DEGREES / QUANTITIES["gyro"][unit.name])
        found = np.flatnonzero(named > limit)
        self._too_fast += len(found)
        if not len(found):
            return
        place = self._series.place(int(rows.places[found[0]]))
        if self._too_fast >= CERTAIN_CASES:
            self._told_rate = True
            what = f"there are values above {limit:.4g} {unit.name} ({named[found[0]]:.6g})"
            refuse(self._findings, self._series, unit, place, what, "deg/s" if unit.name == "rad/s" else "")
        else:
            self._findings.note(
                Kind.IMPLAUSIBLE,
                self._series.file,
                f"{self._series.topic} gyro",
                [(place, f"{named[found[0]]:.6g} {unit.name}")],
                text="kept",
            )

    def _check_forces(self, rows: Rows) -> None:
        """As soon as there is enough: the first portion decides, so that nobody waits for the last one."""
        unit = self._series.units.get("accel")
        if unit is None or len(self._norms) > 1 or len(rows) < CERTAIN_CASES:
            return
        named = self._norms[0] / unit.factor
        for name, factor in QUANTITIES["accel"].items():
            if name != unit.name and 0.8 < named * factor / 9.8 < 1.25:
                place = self._series.place(int(rows.places[0]))
                what = f"its size is {named:.4g} {unit.name} where gravity is 9.8 m/s²"
                refuse(self._findings, self._series, unit, place, what, name)


class MotionUnits:
    """Positions against the velocities beside them, of one series."""

    def __init__(self, series: Series, findings: Findings) -> None:
        self._series = series
        self._findings = findings
        self._columns = series.columns(*PLACE, *VELOCITY)
        self._before: tuple[float, Floats] | None = None
        self._north = _Regression()
        """By itself, since metres to the east take the latitude for granted."""
        self._across = _Regression()
        self._up = _Regression()
        self._largest = 0.0
        self._first_place: int | None = None

    def take(self, rows: Rows) -> None:
        """Sound rows."""
        table = rows.values[:, self._columns]
        times = rows.times_ns / 1e9
        known = np.isfinite(table[:, :2]).all(axis=1)
        table, times = table[known], times[known]
        if not len(table):
            return
        if self._first_place is None:
            self._first_place = int(rows.places[known][0])
        self._largest = max(self._largest, float(np.abs(table[:, :2]).max()))
        if self._before is not None:
            times = np.concatenate(([self._before[0]], times))
            table = np.vstack((self._before[1], table))
        self._before = float(times[-1]), table[-1]
        steps = np.diff(times)
        close = (steps > 0.0) & (steps < LONGEST_STEP_S)
        moved = np.diff(table[:, :3], axis=0)[close] / steps[close, None]
        velocity = (0.5 * (table[1:, 3:] + table[:-1, 3:]))[close]
        metres = EARTH_M / DEGREES
        north, east = moved[:, 0] * metres, moved[:, 1] * metres * np.cos(np.radians(table[1:, 0][close]))
        self._north.add(north, velocity[:, 0])
        self._across.add(north, velocity[:, 0])
        self._across.add(east, velocity[:, 1])
        self._up.add(moved[:, 2], -velocity[:, 2])

    def finish(self) -> None:
        """Judge."""
        if self._first_place is None or not self._series.units:
            return
        self._judge_position()
        self._judge_height()

    def _judge_position(self) -> None:
        ratio = self._north.ratio(least_rms=1.0)
        if ratio is None:
            ratio = self._across.ratio(least_rms=1.0)
        position, velocity = self._series.units.get("position"), self._series.units.get("velocity")
        place = self._series.place(self._first_place or 0)
        if ratio is None:
            if (
                position is not None
                and position.name == "deg"
                and self._largest <= math.pi / 2
                and not position.stated
            ):
                self._findings.note(
                    Kind.DOUBTFUL_UNIT,
                    self._series.file,
                    f"{self._series.topic} position",
                    [(place, f"no latitude or longitude above {self._largest:.4g}°")],
                    text="taken as degrees; if it is radians: --unit position=rad",
                )
            return
        if abs(ratio - 1.0) <= 2 * AGREE:
            return
        for unit in (position, velocity):
            if unit is None:
                continue
            for name, factor in QUANTITIES[unit.quantity].items():
                other = factor / unit.factor
                expected = 1.0 / other if unit.quantity == "position" else other
                if name != unit.name and abs(ratio / expected - 1.0) <= AGREE:
                    what = f"positions move {ratio:.4g} times as far as the velocity says"
                    refuse(self._findings, self._series, unit, place, what, name)
                    return
        self._doubt("velocity", place, f"positions move {ratio:.4g} times as far as the velocity says")

    def _judge_height(self) -> None:
        ratio = self._up.ratio(least_rms=0.2)
        unit = self._series.units.get("height")
        place = self._series.place(self._first_place or 0)
        if ratio is None or unit is None or abs(ratio - 1.0) <= 2 * AGREE:
            return
        what = f"heights change {ratio:.4g} times as fast as the climb says"
        for name, factor in LENGTHS.items():
            if name != unit.name and abs(ratio / (unit.factor / factor) - 1.0) <= AGREE:
                refuse(self._findings, self._series, unit, place, what, name)
                return
        self._doubt("height", place, what + ("; is the vertical velocity upwards?" if ratio < 0 else ""))

    def _doubt(self, quantity: str, place: str, what: str) -> None:
        self._findings.note(
            Kind.DOUBTFUL_UNIT,
            self._series.file,
            f"{self._series.topic} {quantity}",
            [(place, what)],
            text="taken as it is",
        )


class _Regression:
    """Sums for the slope of y over x through the origin."""

    def __init__(self) -> None:
        self._n = 0
        self._xx = self._xy = self._yy = 0.0

    def add(self, y: Floats, x: Floats) -> None:
        """Some pairs."""
        known = np.isfinite(x) & np.isfinite(y)
        x, y = x[known], y[known]
        self._n += len(x)
        self._xx += float(x @ x)
        self._xy += float(x @ y)
        self._yy += float(y @ y)

    def ratio(self, least_rms: float) -> float | None:
        """The slope, when there is motion enough and the two belong together."""
        if self._n < LEAST_STEPS or self._xx < self._n * least_rms**2 or self._yy <= 0.0:
            return None
        correlation = self._xy / math.sqrt(self._xx * self._yy)
        return self._xy / self._xx if abs(correlation) > BELIEVED_CORRELATION else None
