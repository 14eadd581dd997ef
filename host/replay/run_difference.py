"""Two captures, or folders of runs, held against each other: where they part and how far they drift.

Raw topics that both hold are compared record by record; the first difference of each is told. Solutions are
compared at the times of the first run, the second one's interpolated between its rows (`host.replay.road`).
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.capture.blocks import MARK_TOPIC
from host.capture.number_rows import check_numbers
from host.capture.places import NAMES, capture_path
from host.capture.reader import CaptureReader
from host.record.errors import UserError
from host.record.run_data import NAVIGATING
from host.recovery.whole_reader import WholeReader
from host.replay.comparison import Compared, Difference
from host.replay.road import MOTION_COLUMNS, NS, Road, metres_per_radian
from host.score.errors import wrapped

Array = NDArray[np.float64]
STAGES = 8
"""Stretches of the common time for which the difference is told."""
LIMITS_M = (0.001, 0.01, 0.1, 1.0, 10.0)
COLUMNS = ("horizontal_m", "vertical_m", "velocity_mps", "roll_deg", "pitch_deg", "yaw_deg")
FACTS = ("board", "scenario", "profile", "seed", "overrides", "versions", "machine")
TEXTS = ("board_text", "scenario_text")


@dataclass(frozen=True, slots=True)
class Stage:
    """Differences of the solutions in a stretch of time; None: no common solution there."""

    from_s: float
    to_s: float
    rms: dict[str, float | None]
    max: dict[str, float | None]


@dataclass(frozen=True, slots=True)
class RunDifference:
    """What two runs differ in."""

    first: str
    second: str
    facts: dict[str, tuple[Any, Any]]
    """What their manifests differ in."""
    state_hashes: tuple[str | None, str | None]
    ends_s: tuple[float, float]
    divergences: tuple[Difference, ...]
    """The first one of each raw topic, in order of time."""
    compared_topics: tuple[str, ...]
    stages: tuple[Stage, ...]
    exceeds: dict[str, float | None]
    """When the horizontal difference first exceeds a distance in m, s."""

    @property
    def same(self) -> bool:
        """Whether nothing differs that the firmware did or felt."""
        a, b = self.state_hashes
        apart = any((stage.max["horizontal_m"] or 0.0) > 0.0 for stage in self.stages)
        return a == b and not self.divergences and not apart and self.ends_s[0] == self.ends_s[1]

    def to_dict(self) -> dict[str, Any]:
        """For `--json`."""
        return {"same": self.same, **asdict(self)}


def compare_runs(first: Path, second: Path) -> RunDifference:
    """Compare two captures or folders. Raises UserError."""
    a, b = _Run(first), _Run(second)
    divergences, topics = _divergences(a, b)
    if not topics and not (a.rows and b.rows) and None in (a.state_hash, b.state_hash):
        raise UserError(
            f"diff {first} {second}: nothing in them can be compared; they must hold runs of a board: raw"
            " traffic or solutions (navtwin capture export makes tables of what imports hold)"
        )
    stages, exceeds = _growth(a, b)
    return RunDifference(
        first=str(first),
        second=str(second),
        facts=_facts(a.manifest, b.manifest),
        state_hashes=(a.state_hash, b.state_hash),
        ends_s=(a.end_s, b.end_s),
        divergences=tuple(sorted(divergences, key=lambda one: one.time_ns)),
        compared_topics=topics,
        stages=stages,
        exceeds=exceeds,
    )


class _Run:
    """One side: its manifest and solutions; its raw traffic when there is a capture."""

    def __init__(self, given: Path) -> None:
        has_capture = not given.is_dir() or any((given / name).is_file() for name in NAMES)
        self.capture = capture_path(given) if has_capture else None
        self.rows: list[dict[str, Any]] = []
        if self.capture is not None:
            reader = WholeReader(self.capture)
            for message in reader.messages():
                if message.topic == "/solution":
                    row = reader.row(message)
                    check_numbers(row, MOTION_COLUMNS, f"capture {self.capture}: a row of /solution")
                    self.rows.append(row)
            self.manifest = reader.manifest
            self.state_hash = (reader.summary or {}).get("state_hash")
            self.end_s = (reader.end_ns or 0) / NS or (self.rows[-1]["t_s"] if self.rows else 0.0)
        else:
            self._read_folder(given)
        self.road = Road([{**row, "error_north_m": None} for row in self.rows])

    def _read_folder(self, folder: Path) -> None:
        try:
            self.manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
            with (folder / "solution.csv").open(newline="", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
        except (OSError, ValueError) as error:
            raise UserError(
                f"{folder}: holds neither a capture nor manifest.json and solution.csv: {error}"
            ) from None
        self.rows = [{name: _number(text) for name, text in row.items()} for row in rows]
        for row in self.rows:
            check_numbers(row, MOTION_COLUMNS, f"{folder / 'solution.csv'}: a row")
        self.state_hash = self.manifest.get("state_hash")
        self.end_s = float(self.manifest.get("duration_s") or (self.rows[-1]["t_s"] if self.rows else 0.0))


def _number(text: Any) -> Any:
    """Of a cell of a table; what is none is left as it is, and told by whoever needs it."""
    try:
        return float(text) if text else None
    except (TypeError, ValueError):
        return text


def _facts(a: Mapping[str, Any], b: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    facts = {name: (a.get(name), b.get(name)) for name in FACTS if a.get(name) != b.get(name)}
    facts |= {name: ("one text", "another text") for name in TEXTS if a.get(name) != b.get(name)}
    return facts


def _divergences(a: _Run, b: _Run) -> tuple[list[Difference], tuple[str, ...]]:
    if a.capture is None or b.capture is None:
        return [], ()
    readers = CaptureReader(a.capture), CaptureReader(b.capture)
    wires: dict[str, Compared] = {}
    found: dict[str, Difference] = {}
    for pair in zip(readers[0].windows(), readers[1].windows(), strict=False):
        end_ns = min(window.end_ns for window in pair)
        if not wires:
            wires = {topic: Compared(schema) for topic, schema in _common_topics(*readers).items()}
        for topic, wire in wires.items():
            if topic in found:
                continue
            for side, window in zip((wire.recorded, wire.replayed), pair, strict=True):
                side += window.raw.get(topic, b"")
            difference = wire.settle(topic, end_ns)
            if difference is not None:
                found[topic] = difference
        if len(found) == len(wires):
            break
    return list(found.values()), tuple(wires)


def _common_topics(a: CaptureReader, b: CaptureReader) -> dict[str, str]:
    """Raw topics, and their schemas, that two captures hold alike: those of another format may tell more."""
    both = sorted(set(a.raw_topics) & set(b.raw_topics) - {MARK_TOPIC})
    return {topic: str(a.raw_schema(topic)) for topic in both if a.raw_schema(topic) == b.raw_schema(topic)}


def _growth(a: _Run, b: _Run) -> tuple[tuple[Stage, ...], dict[str, float | None]]:
    exceeds: dict[str, float | None] = {f"{limit:g}": None for limit in LIMITS_M}
    navigating = [row for row in a.rows if (row["mode"] or 0) >= NAVIGATING]
    if not navigating or len(b.road) < 2:
        return (), exceeds
    t = np.array([row["t_s"] for row in navigating])
    t = t[(t >= b.road.begin_s) & (t <= b.road.end_s)]
    if not len(t):
        return (), exceeds
    apart = _apart(a.road, b.road, t)
    for limit in LIMITS_M:
        beyond = np.flatnonzero(apart[:, 0] > limit)
        exceeds[f"{limit:g}"] = float(t[beyond[0]]) if len(beyond) else None
    edges = np.linspace(t[0], t[-1], STAGES + 1)
    stages = []
    for k in range(STAGES):
        inside = (t >= edges[k]) & ((t < edges[k + 1]) | (k == STAGES - 1))
        stages.append(_stage(edges[k], edges[k + 1], apart[inside]))
    return tuple(stages), exceeds


def _stage(from_s: float, to_s: float, apart: Array) -> Stage:
    known = apart[np.isfinite(apart).all(axis=1)]
    if not len(known):
        nothing: dict[str, float | None] = dict.fromkeys(COLUMNS)
        return Stage(float(from_s), float(to_s), nothing, nothing)
    rms = np.sqrt(np.mean(known * known, axis=0)).tolist()
    largest = np.abs(known).max(axis=0).tolist()
    return Stage(
        float(from_s),
        float(to_s),
        dict(zip(COLUMNS, rms, strict=True)),
        dict(zip(COLUMNS, largest, strict=True)),
    )


def _apart(a: Road, b: Road, t: Array) -> Array:
    """Differences at times, columns as COLUMNS."""
    times_ns = np.rint(t * NS).astype(np.int64)
    one, other = a.truth(times_ns), b.truth(times_ns)
    place = np.column_stack((one.latitude, one.longitude, one.height))
    scale = metres_per_radian(place)
    north = (other.latitude - one.latitude) * scale[:, 0]
    east = wrapped(other.longitude - one.longitude) * scale[:, 1]
    return np.column_stack(
        (
            np.hypot(north, east),
            other.height - one.height,
            np.linalg.norm(other.v_ned - one.v_ned, axis=1),
            np.degrees(wrapped(other.roll - one.roll)),
            np.degrees(other.pitch - one.pitch),
            np.degrees(wrapped(other.yaw - one.yaw)),
        )
    )
