"""What is asked of an import and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from host.capture.topics import IMPORT_FORMAT
from host.importers.findings import Finding, Findings
from host.importers.series import Stream
from host.importers.units import Units
from host.record.errors import UserError

Meter = Callable[[int], None]
"""Told how many further bytes of the input have been worked off."""
Progress = Callable[[int, int], None]
"""(bytes worked off, bytes in all)."""


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file, and the part it plays when that was said (`imu=drive.txt`)."""

    path: Path
    role: str | None = None

    @property
    def name(self) -> str:
        """For findings."""
        return self.path.name


@dataclass(frozen=True, slots=True)
class ImportRequest:
    """One import. None: as the recording says, or as is usual."""

    kind: str
    files: tuple[InputFile, ...]
    target: Path
    mapping: Path | None = None
    dbc: Path | None = None
    units: tuple[str, ...] = ()
    leap_seconds: int | None = None
    week: int | None = None
    date: str | None = None
    geoid_separation_m: float | None = None
    accuracy: str | None = None
    """Of receivers that tell none: horizontal, vertical in m, speed in m/s, "1.0,2.2,0.15"."""
    progress: Progress | None = None


@dataclass(frozen=True, slots=True)
class Task:
    """What a reader of one kind of recording works with."""

    request: ImportRequest
    findings: Findings
    units: Units
    meter: Meter


@dataclass(slots=True)
class Recording:
    """Recorded streams. Their times are GPS time when `is_absolute`, else the recording's own clock."""

    streams: list[Stream]
    is_absolute: bool
    facts: dict[str, Any] = field(default_factory=dict)
    """For the manifest: what was assumed."""


Reader = Callable[[Task], Recording]


@dataclass(frozen=True, slots=True)
class ImportResult:
    """What was imported."""

    capture: Path
    kind: str
    duration_s: float
    begins: str | None
    """UTC of the beginning; None: not known."""
    counts: Mapping[str, int]
    """Rows or records of each topic."""
    left_out: int
    findings: list[Finding]
    uses: list[str]
    """What the capture can be used for, in words."""
    wall_s: float

    def to_dict(self) -> dict[str, Any]:
        """For `--json`; the keys are stable."""
        return {
            "format": IMPORT_FORMAT,
            "capture": str(self.capture),
            "kind": self.kind,
            "duration_s": self.duration_s,
            "begins": self.begins,
            "topics": dict(self.counts),
            "left_out": self.left_out,
            "findings": [asdict(finding) for finding in self.findings],
            "uses": self.uses,
            "wall_s": self.wall_s,
        }


def only_file(task: Task, example: str) -> InputFile:
    """The one file of a kind that has one. Raises UserError."""
    files = task.request.files
    if len(files) != 1:
        raise UserError(
            f"import {task.request.kind}: takes one file, not {len(files)}; for example navtwin import"
            f" {task.request.kind} {example} -o drive.mcap"
        )
    return files[0]
