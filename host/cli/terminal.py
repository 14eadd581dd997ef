"""How things look in a terminal: consoles, result tables, the progress bar."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from host.record.result import Progress as ProgressCallback
from host.record.result import RunResult
from host.report.summary import MET, NOT_MET, Section, sections, verdict

WIDTH_OF_FILES = 140
REFRESH_S = 0.1
EVENTS_SHOWN = 12


def standard_output() -> Console:
    """Console on standard output; wide enough for the tables when that is a file or a pipe."""
    return Console(width=None if sys.stdout.isatty() else WIDTH_OF_FILES, highlight=False, emoji=False)


def standard_error() -> Console:
    """Console on standard error."""
    width = None if sys.stderr.isatty() else WIDTH_OF_FILES
    return Console(stderr=True, width=width, highlight=False, emoji=False)


def print_result(console: Console, result: RunResult) -> None:
    """All tables of a result."""
    console.print()
    for section in sections(result):
        shown = section.rows[:EVENTS_SHOWN] if section.title == "Events" else section.rows
        console.print(_table(section, shown))
        left = len(section.rows) - len(shown)
        if left > 0:
            console.print(f"  … and {left} more in the report\n", style="dim")


def print_section(console: Console, section: Section) -> None:
    """One table."""
    console.print(_table(section, section.rows))


def print_verdict(console: Console, result: RunResult) -> None:
    """One line with the verdict and the speed, where the report lies, and what was to break and did not."""
    style = "bold green" if result.ok else "bold red"
    speed = (
        f"{result.duration_s:,.0f} s in {result.wall_s:,.1f} s, {result.real_time_factor:,.0f} × real time"
    )
    name = f"{result.board} {result.scenario} {result.profile} seed {result.seed}"
    for fault in result.faults:
        if not fault.fired:
            console.print(Text(f"fault {fault.name!r} never fired", "yellow"), soft_wrap=True)
    console.print(Text.assemble(f"{name}: ", (verdict(result), style), f" ({speed})"), soft_wrap=True)
    if result.out_dir is not None:
        console.print(Text(f"report: {result.out_dir / 'report.html'}"), soft_wrap=True)


def _table(section: Section, rows: tuple[tuple[str, ...], ...]) -> Table:
    note = ("\n" + section.note, "not bold dim") if section.note else ""
    title = Text.assemble((section.title, "bold"), note)
    table = Table(title=title, title_justify="left", title_style="", box=SIMPLE_HEAD, pad_edge=False)
    for place, name in enumerate(section.columns):
        table.add_column(name, justify="left" if section.is_text(place) else "right", overflow="fold")
    for row in rows:
        table.add_row(*map(_cell, row))
    return table


def _cell(text: str) -> Text:
    return Text(text, style={MET: "green", NOT_MET: "bold red"}.get(text, ""))


@contextmanager
def progress_bar(title: str, quiet: bool) -> Iterator[ProgressCallback | None]:
    """A bar on standard error that tells the speed; nothing when quiet or not in a terminal."""
    console = standard_error()
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:,.0f}/{task.total:,.0f} s"),
        TextColumn("[cyan]{task.fields[speed]}"),
        TimeRemainingColumn(compact=True),
    )
    with Progress(*columns, console=console, auto_refresh=False, transient=True) as bar:
        task = bar.add_task(title, total=1.0, speed="")
        yield _Pacer(bar, task)


class _Pacer:
    """Hands progress to the bar, but no more often than an eye can follow."""

    def __init__(self, bar: Progress, task: TaskID) -> None:
        self._bar = bar
        self._task = task
        self._began: float | None = None
        self._drawn = 0.0

    def __call__(self, virtual_s: float, duration_s: float) -> None:
        now = time.monotonic()
        if self._began is None:
            self._began = now
        if now - self._drawn < REFRESH_S and virtual_s < duration_s:
            return
        self._drawn = now
        elapsed = now - self._began
        speed = f"{virtual_s / elapsed:,.0f} × real time" if elapsed > 0.2 else ""
        self._bar.update(self._task, completed=virtual_s, total=duration_s, speed=speed)
        self._bar.refresh()
