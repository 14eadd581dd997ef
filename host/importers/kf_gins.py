"""KF-GINS text files (i2Nav, Wuhan University): increments of an IMU, receiver positions, and a reference.

    IMU    second of week | Δθ forward right down, rad | Δv forward right down, m/s            (7 columns)
    GNSS   second of week | latitude longitude, ° | height, m | σ north east down, m            (7)
           … | v north east down, m/s | σ of these                                              (13)
    truth  week | second of week | latitude longitude, ° | height, m | v north east down, m/s
           | roll pitch yaw, °                                                                  (11)

A week 0 in the reference (KF-GINS writes it into its own results) says nothing. Increments end at their time
stamp: rate and force are their quotients by the step, and hold for its middle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from host.importers import topics
from host.importers.findings import Findings, Kind
from host.importers.number_lines import ns_of_seconds, number_blocks
from host.importers.request import InputFile, Recording, Task
from host.importers.series import Floats, Integers, Rows, Stream, in_line
from host.importers.time_base import NS, WEEK_NS
from host.record.errors import UserError

ROLES = ("imu", "gnss", "truth")
EXAMPLE = "navtwin import kf-gins imu=Leador-A15.txt gnss=GNSS-RTK.txt truth=truth.nav -o drive.mcap"
LONGEST_STEP_S = 0.5
"""A longer step between increments is a gap, whose increment is not spread over it."""
NEUTRAL_WEEK = 2000


def read_kf_gins(task: Task) -> Recording:
    """Each file by its part, which the number of columns and the sizes of numbers tell when not said."""
    files = [(file, file.role or _role(file.path)) for file in task.request.files]
    for role in ROLES:
        if sum(one == role for _, one in files) > 1:
            raise UserError(f"import kf-gins: two files are taken for {role}; say which is which: {EXAMPLE}")
    roles = {role: file for file, role in files}
    week = _week(task, roles.get("truth"))
    streams: list[Stream] = []
    if "imu" in roles:
        streams.append(_imu(task, roles["imu"], week))
    if "gnss" in roles:
        streams.append(_gnss(task, roles["gnss"], week))
    if "truth" in roles:
        streams.append(_truth(task, roles["truth"], week))
    return Recording(streams, is_absolute=True, facts={"gps_week": week})


def _first_rows(path: Path) -> list[list[float]]:
    rows = []
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for line in file.readlines(1 << 16):
            try:
                row = [float(part) for part in line.split()]
            except ValueError:
                continue
            if row:
                rows.append(row)
    return rows


def _role(path: Path) -> str:
    """What a file is by its first rows."""
    rows = _first_rows(path)
    widths = {len(row) for row in rows}
    if widths == {11}:
        return "truth"
    if widths == {13}:
        return "gnss"
    if widths == {7}:
        table = np.array(rows)
        return "imu" if float(np.median(np.abs(table[:, 1:]))) < 0.2 and len(rows) > 1 else "gnss"
    found = ", ".join(map(str, sorted(widths))) or "no"
    raise UserError(
        f"{path}: its rows have {found} columns of numbers; KF-GINS has 7 (IMU,"
        f" GNSS), 13 (GNSS with velocity) or 11 (truth); say which part it is: {EXAMPLE}"
    )


def _week(task: Task, truth: InputFile | None) -> int:
    if task.request.week is not None:
        return task.request.week
    told = 0 if truth is None else _told_week(truth.path)
    if told:
        return told
    text = f"no file tells the GPS week; taken as {NEUTRAL_WEEK}: say which with --week"
    task.findings.note(Kind.NO_TIME, task.request.files[0].name, text=text)
    return NEUTRAL_WEEK


def _told_week(path: Path) -> int:
    for values, _ in number_blocks(path, (0,), None, Findings(), _nothing):
        week = float(values[0, 0])
        if week.is_integer() and 0 <= week < 10_000:
            return int(week)
        raise UserError(f"{path}: its first column should be the GPS week, e.g. 2017, but is {week:g}")
    return 0


def _nothing(_size: int) -> None:
    pass


def _times(week: int, seconds: Floats) -> Integers:
    return week * WEEK_NS + ns_of_seconds(seconds)


class _Unrolled:
    """Seconds of week that go on behind the end of the week."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._weeks = 0

    def times(self, week: int, seconds: Floats) -> Integers:
        """GPS time of seconds of week, in the order of the file."""
        before = np.concatenate(([seconds[0] if self._last is None else self._last], seconds[:-1]))
        rolls = np.cumsum(before - seconds > WEEK_NS / NS / 2)
        weeks = self._weeks + rolls
        self._weeks, self._last = int(weeks[-1]), float(seconds[-1])
        return _times(week, seconds) + weeks.astype(np.int64) * WEEK_NS


def _imu(task: Task, file: InputFile, week: int) -> Iterator[Rows]:
    units = {"gyro": task.units.of("gyro", "rad/s"), "accel": task.units.of("accel", "m/s2")}
    series = topics.samples("imu", file.name, in_line, units)
    return _increments(task, file, week, series, units["gyro"].factor, units["accel"].factor)


def _increments(
    task: Task, file: InputFile, week: int, series: topics.Series, gyro: float, accel: float
) -> Iterator[Rows]:
    unrolled = _Unrolled()
    last: tuple[int, float] | None = None
    for values, lines in number_blocks(file.path, range(7), None, task.findings, task.meter):
        times = unrolled.times(week, values[:, 0])
        before = np.concatenate(([times[0] if last is None else last[0]], times[:-1]))
        steps = (times - before) / NS
        usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else math.nan
        last = int(times[-1]), usual
        # Rows that do not go on are told by the inspection, which sees their own times.
        spread = np.where((steps > 0.0) & (steps < LONGEST_STEP_S), steps, usual)
        table = np.column_stack((values[:, 1:7] / spread[:, None], np.full(len(values), np.nan)))
        table[:, :3] *= gyro
        table[:, 3:6] *= accel
        middle = times - np.rint(np.where(np.isfinite(spread), spread, 0.0) / 2 * NS).astype(np.int64)
        yield Rows(series, middle, table, lines)


def _gnss(task: Task, file: InputFile, week: int) -> Iterator[Rows]:
    units = {
        "position": task.units.of("position", "deg"),
        "height": task.units.of("height", "m"),
        "velocity": task.units.of("velocity", "m/s"),
    }
    series = topics.epochs(file.name, in_line, units)
    width = min(map(len, _first_rows(file.path)), default=7)
    place = units["position"].factor
    unrolled = _Unrolled()

    def rows() -> Iterator[Rows]:
        for values, lines in number_blocks(
            file.path, range(13 if width >= 13 else 7), None, task.findings, task.meter
        ):
            table = np.full((len(values), len(series.table.columns) - 1), np.nan)
            table[:, 0] = 1.0
            table[:, 1:3] = values[:, 1:3] * place
            table[:, 3] = values[:, 3] * units["height"].factor
            table[:, 7] = np.hypot(values[:, 4], values[:, 5])
            table[:, 8] = values[:, 6]
            if width >= 13:
                table[:, 4:7] = values[:, 7:10] * units["velocity"].factor
                table[:, 9] = np.sqrt(np.mean(values[:, 10:13] ** 2, axis=1))
            yield Rows(series, unrolled.times(week, values[:, 0]), table, lines)

    return rows()


def _truth(task: Task, file: InputFile, week: int) -> Iterator[Rows]:
    units = {
        "position": task.units.of("position", "deg"),
        "height": task.units.of("height", "m"),
        "velocity": task.units.of("velocity", "m/s"),
        "attitude": task.units.of("attitude", "deg"),
    }
    series = topics.truth(file.name, in_line, units)

    def rows() -> Iterator[Rows]:
        for values, lines in number_blocks(
            file.path, range(11), None, task.findings, task.meter, times=(0, 1)
        ):
            weeks = values[:, 0]
            sound = np.isfinite(weeks) & (weeks >= 0) & (weeks < 10_000)
            values, lines = values[sound], lines[sound]
            if not len(values):
                continue
            table = np.empty((len(values), 9))
            table[:, :2] = values[:, 2:4] * units["position"].factor
            table[:, 2] = values[:, 4] * units["height"].factor
            table[:, 3:6] = values[:, 5:8] * units["velocity"].factor
            table[:, 6:9] = values[:, [10, 9, 8]] * units["attitude"].factor
            told = values[:, 0].astype(np.int64)
            times = np.where(told == 0, week, told) * WEEK_NS + ns_of_seconds(values[:, 1])
            yield Rows(series, times, table, lines)

    return rows()
