"""A result as Markdown, for the page of a merge request: the verdict and what missed first, the rest folded.

`summary` is for any kind of result that can say its tables as `host.report.summary.Section`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from host.record.result import RunResult
from host.report.summary import NOT_MET, Section, sections, verdict

SPECIAL = re.compile(r"([\\`*_\[\]|~])")
EVENTS_SHOWN = 20
BAD = (NOT_MET, "WORSE")
"""Verdicts of expectations and of comparisons that a reader must not miss."""


def run_summary(result: RunResult, command: str | None = None, extra: Sequence[Section] = ()) -> str:
    """One run. `command`: the command line that makes it again; `extra`: tables below the verdict."""
    tables = sections(result)
    shown = [*(section for section in tables if section.title == "Expectations"), *extra]
    folded = [section for section in tables if section not in shown]
    title = f"{result.board} {result.scenario} {result.profile} seed {result.seed}"
    speed = f"{result.duration_s:,.0f} s of virtual time, {result.real_time_factor:,.0f} × real time"
    return summary(title, verdict(result), shown, folded, [speed], command)


def summary(
    title: str,
    verdict_text: str,
    shown: Sequence[Section],
    folded: Sequence[Section] = (),
    notes: Sequence[str] = (),
    command: str | None = None,
) -> str:
    """A whole summary: heading, tables `shown` with their notes, those to be unfolded, notes, the command."""
    parts = [f"### {plain(title)}: {plain(verdict_text)}"]
    for section in shown:
        parts += [table(section)] if section.rows else []
        parts += [plain(section.note)] if section.note else []
    if folded:
        inner = "\n\n".join(f"**{plain(section.title)}**\n\n{table(section)}" for section in folded)
        parts.append(f"<details><summary>All figures</summary>\n\n{inner}\n\n</details>")
    parts += [plain(note) for note in notes]
    if command is not None:
        parts.append(f"Run it again:\n\n{_fenced(command)}")
    return "\n\n".join(parts) + "\n"


def table(section: Section) -> str:
    """One table; numbers stand to the right, what is not met is bold, long lists of events are cut."""
    rows = section.rows[:EVENTS_SHOWN] if section.title == "Events" else section.rows
    rules = ["---" if section.is_text(place) else "---:" for place in range(len(section.columns))]
    lines = [_row([plain(name) for name in section.columns]), _row(rules)]
    lines += [_row([_cell(text) for text in row]) for row in rows]
    left = len(section.rows) - len(rows)
    return "\n".join(lines) + (f"\n\n… and {left} more in the report" if left else "")


def plain(text: str) -> str:
    """Text that Markdown and HTML leave as it is, on one line."""
    escaped = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return SPECIAL.sub(r"\\\1", " ".join(escaped.split()))


def _cell(text: str) -> str:
    return f"**{plain(text)}**" if text in BAD else plain(text)


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _fenced(command: str) -> str:
    """A code block whose fence is longer than any in the text."""
    longest = max((len(run) for run in re.findall(r"`+", command)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}sh\n{command}\n{fence}"
