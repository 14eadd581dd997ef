"""A drive from its scenario to its files, streamed: memory does not grow with its length."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from host.simulate.baseline_rows import BASELINE_NAME
from host.simulate.epochs import Epoch, EpochFeed
from host.simulate.formats.known import Format
from host.simulate.formats.writer import Writer
from host.simulate.part_files import PartFiles
from host.simulate.rows import gnss_rows
from host.simulate.stream import NS, Drive

Progress = Callable[[float, float], None]


@dataclass(frozen=True, slots=True)
class Simulated:
    """What came of it."""

    samples: int
    epochs: int
    duration_s: float
    wall_s: float
    """Generation and writing, without start-up."""
    files: tuple[Path, ...]

    @property
    def samples_per_s(self) -> float:
        """Inertial samples, each with its truth, in a second of wall-clock time."""
        return self.samples / self.wall_s if self.wall_s > 0.0 else 0.0


def simulate(
    drive: Drive, path: Path | None, form: Format | None, about: dict[str, Any], progress: Progress | None
) -> Simulated:
    """Generate the drive, and write it when there is a path, but not over its scenario. Raises UserError."""
    begin = time.perf_counter()
    with PartFiles(drive.request.scenario.path) as files:
        writer = None
        if path is not None and form is not None:
            writer = form.writer(drive, path, files, about)
        epochs = EpochFeed(drive.receiver_epochs())
        samples = 0
        told_ns = -1
        for block in drive.blocks():
            samples += len(block.times_ns)
            end_ns = int(block.times_ns[-1])
            due = epochs.until(end_ns)
            if writer is not None:
                writer.add_block(block)
                _add_epochs(drive, writer, due)
            _add_ambients(drive, writer, told_ns, end_ns)
            told_ns = end_ns
            if progress is not None:
                progress(end_ns / NS, drive.duration_ns / NS)
        rest = epochs.until(drive.duration_ns)
        if writer is not None:
            _add_epochs(drive, writer, rest)
        _add_ambients(drive, writer, told_ns, drive.duration_ns)
        if writer is not None:
            writer.finish()
    wall_s = time.perf_counter() - begin
    return Simulated(samples, drive.epochs, drive.duration_ns / NS, wall_s, tuple(files.paths))


def _add_epochs(drive: Drive, writer: Writer, epochs: list[Epoch]) -> None:
    if not epochs:
        return
    writer.add_gnss(gnss_rows(epochs))
    if drive.request.second_antenna_m is not None:
        writer.add_side(BASELINE_NAME, drive.baseline_rows(epochs))


def _add_ambients(drive: Drive, writer: Writer | None, after_ns: int, end_ns: int) -> None:
    for ambient in drive.ambients:
        rows = drive.ambient_rows(ambient, after_ns, end_ns)
        if len(rows) and writer is not None:
            writer.add_side(ambient.sensor.name, rows)
