"""Physical replay of an imported capture: what it measured, and the setting that it lacks.

An import has no board and no scenario. The board is named by the user; the scenario is made of the place and
the time at which the recording begins. Virtual time begins with the first whole second of GPS time at which
there are inertial samples (and a reference, where there is one before long), so that receivers' epochs keep
their instants.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.description import load_board
from boards.places import board_folder
from host.capture.inertial_samples import IMU, InertialSamples
from host.capture.number_rows import check_numbers
from host.capture.reader import CaptureReader, RawMessage
from host.importers.time_base import utc_text
from host.importers.topics import PLACE, VELOCITY
from host.record.errors import UserError
from host.record.manifest import build_manifest
from host.record.run_data import NAVIGATING
from host.replay.request import ReplayRequest
from host.replay.road import AGAINST_RECEIVER, AGAINST_TRUTH, NS, Road, metres_per_radian

Array = NDArray[np.float64]
IMU_TOPIC = "/imu/"
COLUMNS = (*IMU.columns, "temperature_degc")
NEEDED_OF_TRUTH = (*PLACE, *VELOCITY)
NEEDED_OF_EPOCHS = ("fix", *NEEDED_OF_TRUTH)
LONGEST_EPOCH_STEP_S = 1.1
LEAST_SPEED_MPS = 1.0
"""Below it a course means nothing."""
LATEST_START_S = 10.0
"""Other streams that begin later than this behind the inertial samples are not waited for."""


class ImportedContent:
    """Implements `host.replay.recorded_world.RecordedContent`: some 70 bytes a sample in memory."""

    def __init__(self, reader: CaptureReader) -> None:
        """Reads all of it. Raises UserError when there are no inertial samples or no epochs."""
        samples: dict[str, array[float]] = {}
        rows: dict[str, list[dict[str, Any]]] = {"/gnss": [], "/truth": []}
        for message in reader.messages():
            if message.topic.startswith(IMU_TOPIC):
                row = self._numbers(reader, message, COLUMNS[1:])
                values = [math.nan if row[name] is None else row[name] for name in COLUMNS]
                samples.setdefault(message.topic.removeprefix(IMU_TOPIC), array("d")).extend(values)
            elif message.topic in rows:
                columns = NEEDED_OF_EPOCHS if message.topic == "/gnss" else NEEDED_OF_TRUTH
                rows[message.topic].append(self._numbers(reader, message, columns))
        tables = {name: np.array(flat).reshape(-1, len(COLUMNS)) for name, flat in samples.items()}
        tables = {name: table for name, table in tables.items() if len(table) > 1}
        self._check(reader, tables, rows["/gnss"])
        first = next(iter(tables.values()))
        self.start_s = _start_s(first[0, 0], rows)
        """Of virtual time 0 on the capture's axis, a whole second."""
        fixes = [row for row in rows["/gnss"] if row["fix"] and row["latitude_deg"] is not None]
        self.first_fix = next((row for row in fixes if row["t_s"] >= self.start_s), fixes[-1])
        self.epochs = _with_velocities(self._shifted(rows["/gnss"]))
        self.climbs: list[dict[str, Any]] = []
        self.samples = {name: _samples(table, self.start_s) for name, table in tables.items()}
        self.mountings = {name: np.eye(3) for name in tables}
        self.road_lever_arm = np.zeros(3)
        truth = self._shifted(rows["/truth"])
        if truth:
            self.road = Road([_as_solution(row) for row in truth], AGAINST_TRUTH)
        else:
            known = [row for row in self.epochs if row["fix"] and row["height_m"] is not None]
            self.road = Road(_along_course([_as_solution(row) for row in known]), AGAINST_RECEIVER)
        ends = [float(first[-1, 0]) - self.start_s, self.epochs[-1]["t_s"] if self.epochs else 0.0]
        if truth:
            ends.append(truth[-1]["t_s"])
        if not any(self.start_s <= row["t_s"] <= float(first[-1, 0]) for row in fixes):
            raise UserError(
                f"capture {reader.path}: there is no receiver epoch with a fix from {first[0, 0]:,.3f} to"
                f" {first[-1, 0]:,.3f} s, where the inertial samples lie: their clocks differ, or the two are"
                " not of one drive"
            )
        self.end_ns = math.floor(10.0 * min(ends)) * NS // 10
        if self.end_ns < NS:
            raise UserError(
                f"capture {reader.path}: inertial samples and receiver have less than a second in common"
            )

    def _numbers(self, reader: CaptureReader, message: RawMessage, columns: Sequence[str]) -> dict[str, Any]:
        row = reader.row(message)
        check_numbers(row, columns, f"capture {reader.path}: a row of {message.topic}")
        return row

    def _check(self, reader: CaptureReader, tables: dict[str, Array], epochs: list[dict[str, Any]]) -> None:
        has_fix = any(row["fix"] and row["latitude_deg"] is not None for row in epochs)
        if tables and has_fix:
            return
        no_samples = [] if tables else ["inertial samples"]
        no_epochs = [] if has_fix else ["receiver epochs with a fix"]
        lacking = " and ".join(no_samples + no_epochs)
        raise UserError(
            f"capture {reader.path}: it holds no {lacking}, so no board can be driven by it; navtwin capture"
            " export gives what it holds"
        )

    def _shifted(self, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
        return [{**row, "t_s": row["t_s"] - self.start_s} for row in rows if row["t_s"] >= self.start_s - 1.0]


def _start_s(first_sample_s: float, rows: dict[str, list[dict[str, Any]]]) -> float:
    firsts = [known[0]["t_s"] for known in rows.values() if known]
    awaited = [first for first in firsts if first <= first_sample_s + LATEST_START_S]
    return float(math.ceil(round(max(first_sample_s, *awaited), 6)) if awaited else math.ceil(first_sample_s))


def _with_velocities(epochs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Epochs of receivers that told no velocity, or none vertically, get the slope of their positions."""
    fixed = [row for row in epochs if row["fix"] and row["height_m"] is not None]
    if len(fixed) < 2 or all(row[name] is not None for row in fixed for name in VELOCITY):
        return epochs
    times = np.array([row["t_s"] for row in fixed])
    place = np.array([[row[name] for name in PLACE] for row in fixed])
    place[:, :2] = np.unwrap(np.radians(place[:, :2]), axis=0)
    metres = np.column_stack((metres_per_radian(place), -np.ones(len(place))))
    before, after = (
        np.maximum(np.arange(len(times)) - 1, 0),
        np.minimum(np.arange(len(times)) + 1, len(times) - 1),
    )
    steps = times[after] - times[before]
    slopes = (place[after] - place[before]) * metres / steps[:, None]
    slopes[steps > 2 * LONGEST_EPOCH_STEP_S] = np.nan
    for row, slope in zip(fixed, slopes.tolist(), strict=True):
        for name, value in zip(VELOCITY, slope, strict=True):
            if row[name] is None and math.isfinite(value):
                row[name] = value
    return epochs


def _samples(table: Array, start_s: float) -> InertialSamples:
    times_ns = np.rint((table[:, 0] - start_s) * NS).astype(np.int64)
    warm = np.isfinite(table[:, 7])
    return InertialSamples(times_ns, table[:, 4:7], np.radians(table[:, 1:4]), times_ns[warm], table[warm, 7])


def _as_solution(row: dict[str, Any]) -> dict[str, Any]:
    """With the columns that `Road` looks at; NaN for angles that nobody knows."""
    unknown = {name: math.nan for name in ("v_north_mps", "v_east_mps", "v_down_mps") if row[name] is None}
    angles = {name: math.nan for name in ("yaw_deg", "pitch_deg", "roll_deg") if row.get(name) is None}
    return {**row, **unknown, **angles, "mode": NAVIGATING, "error_north_m": None}


def _along_course(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The body points where it moves, and lies level across: all that a receiver knows of attitude."""
    yaw = pitch = 0.0
    for row in rows:
        for name in VELOCITY:
            row[name] = row[name] if math.isfinite(row[name]) else 0.0
        north, east, down = (row[name] for name in VELOCITY)
        speed = math.hypot(north, east)
        if speed > LEAST_SPEED_MPS:
            yaw = math.degrees(math.atan2(east, north))
            pitch = math.degrees(math.atan2(-down, speed))
        row |= {"yaw_deg": yaw, "pitch_deg": pitch, "roll_deg": 0.0}
    return rows


def imported_manifest(
    content: ImportedContent, reader: CaptureReader, request: ReplayRequest
) -> dict[str, Any]:
    """The manifest that a run in this setting would have. Raises UserError when no board is named."""
    if request.board is None:
        raise UserError(
            f"capture {request.capture}: it was imported and has no board; name one, for example"
            f" navtwin replay {request.capture} --board car_mems --mode physical"
        )
    board = load_board(request.board)
    if content.road.known_from == AGAINST_RECEIVER:
        antennas = [chip.lever_arm_m for chip in board.chips.values() if chip.world == "gnss"]
        content.road_lever_arm = np.array(antennas[0] if antennas else (0.0, 0.0, 0.0))
    text = (board_folder(request.board) / "board.toml").read_text(encoding="utf-8")
    name = f"import-{reader.manifest.get('kind', 'recording')}"
    profile = request.profile or board.default_profile
    try:
        scenario = _scenario_text(content, reader.manifest.get("clock") or {})
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError) as error:
        raise UserError(
            f"capture {request.capture}: its manifest is damaged: 'clock' is {reader.manifest['clock']!r:.80}"
            f" ({type(error).__name__}: {error}); an import writes a table there"
        ) from None
    return build_manifest(board.name, text, name, scenario, profile, 1, request.overrides)


def _scenario_text(content: ImportedContent, clock: dict[str, Any]) -> str:
    fix = content.first_fix
    separation = fix.get("geoid_separation_m") or 0.0
    lines = [
        f"duration_s = {content.end_ns / NS}",
        "[place]",
        f"latitude_deg = {fix['latitude_deg']:.9f}",
        f"longitude_deg = {(fix['longitude_deg'] + 180.0) % 360.0 - 180.0:.9f}",
        f"height_m = {fix['height_m'] or 0.0:.3f}",
        f"geoid_separation_m = {separation:.3f}",
    ]
    if clock.get("base") == "gps":
        leaps = int(clock["leap_seconds"])
        start_ns = int(clock["origin_ns"]) + round(content.start_s) * NS
        lines += ["[start]", f'utc = "{utc_text(start_ns, leaps)}"', f"leap_seconds = {leaps}"]
    return "\n".join(lines) + "\n"
