"""What `navtwin import` does and prints."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeRemainingColumn

from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import STANDARD_OUTPUT, check_files, write_json
from host.cli.terminal import print_section, standard_error, standard_output
from host.importers.importing import import_recording
from host.importers.request import ImportRequest, ImportResult, InputFile
from host.importers.request import Progress as Told
from host.report.summary import Section

ROLES = ("imu", "gnss", "truth")


@dataclass(frozen=True, slots=True)
class Wanted:
    """The command line."""

    kind: str
    files: tuple[str, ...]
    target: Path
    mapping: Path | None
    dbc: Path | None
    units: tuple[str, ...]
    leap_seconds: int | None
    week: int | None
    date: str | None
    geoid_separation_m: float | None
    accuracy: str | None


def execute(wanted: Wanted, target: str | None, quiet: bool) -> int:
    """Import, write, print; the exit code."""
    for file in map(_input_file, wanted.files):
        check_files(("--json", target), read=file.path)
    with _progress_bar(f"import {wanted.kind}", quiet) as progress:
        result = import_recording(
            ImportRequest(
                kind=wanted.kind,
                files=tuple(map(_input_file, wanted.files)),
                target=wanted.target,
                mapping=wanted.mapping,
                dbc=wanted.dbc,
                units=wanted.units,
                leap_seconds=wanted.leap_seconds,
                week=wanted.week,
                date=wanted.date,
                geoid_separation_m=wanted.geoid_separation_m,
                accuracy=wanted.accuracy,
                progress=progress,
            )
        )
    write_json(result.to_dict(), target)
    if not quiet and target != STANDARD_OUTPUT:
        _tell(result)
    return EXIT_MET


def _input_file(text: str) -> InputFile:
    role, equals, path = text.partition("=")
    if equals and role in ROLES:
        return InputFile(Path(path), role)
    return InputFile(Path(text))


def _tell(result: ImportResult) -> None:
    console = standard_output()
    rows = tuple((topic, f"{count:,}") for topic, count in result.counts.items())
    print_section(console, Section("Topics", ("topic", "records"), rows))
    for finding in result.findings:
        console.print(f"- {finding.line()}", soft_wrap=True, markup=False)
    for use in result.uses:
        console.print(f"for: {use}", soft_wrap=True, markup=False)
    begins = "" if result.begins is None else f" from {result.begins}"
    left_out = f", {result.left_out:,} rows left out" if result.left_out else ""
    console.print(
        f"{result.capture}: {result.duration_s:,.3f} s{begins}, {len(result.findings)} findings{left_out}"
        f" ({result.wall_s:,.1f} s)",
        soft_wrap=True,
        markup=False,
    )


@contextmanager
def _progress_bar(title: str, quiet: bool) -> Iterator[Told | None]:
    """A bar on standard error that counts bytes; nothing when quiet or not in a terminal."""
    console = standard_error()
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        DownloadColumn(),
        TimeRemainingColumn(compact=True),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, whole: bar.update(task, completed=done, total=whole)
