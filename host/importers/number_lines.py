"""Text files of numbers, read in blocks of lines with their line numbers.

A block goes through NumPy's own parser; when that finds something it cannot read, the block is read line by
line, and lines that are no row are told and left out.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TextIO

import numpy as np

from host.importers.findings import Findings, Kind
from host.importers.series import ROWS_AT_ONCE, Floats, Integers, in_line
from host.importers.time_base import NS
from host.record.errors import UserError

LONGEST_LINE = 1 << 14
SHOWN = 60
LATEST_S = 9.0e9
"""Of any clock, in s: what int64 ns can hold."""
HOPELESS = 20
"""So many lines that are no rows, and not one that is: another kind of file."""

Cell = Callable[[str], float]


def number_blocks(
    path: Path,
    columns: Sequence[int],
    delimiter: str | None,
    findings: Findings,
    meter: Callable[[int], None],
    *,
    skip: int = 0,
    comments: str = "#%",
    cells: Sequence[Cell | None] = (),
    times: Sequence[int] = (0,),
    scales: Mapping[int, float] = MappingProxyType({}),
) -> Iterator[tuple[Floats, Integers]]:
    """(values (n, len(columns)), line numbers) block by block. Raises UserError when nothing is a row.

    `columns` from 0; `delimiter` None: white space; `skip` lines at the beginning; `cells`: for each column
    how its text becomes a number when that is not its own way. An empty cell is NaN. `times`: which of the
    columns are times; rows without a time that can be are told and left out. `scales`: factors of columns.
    """
    has_own_cells = any(cell is not None for cell in cells)
    readers = [cell or _number for cell in cells] or [_number] * len(columns)
    good = bad = 0
    with _opened(path) as file:
        for lines, numbers in _blocks(file, skip, comments, meter):
            values = None if has_own_cells else _fast(lines, columns, delimiter)
            places = numbers
            if values is None:
                values, places, wrong = _slow(lines, numbers, columns, delimiter, readers)
                bad += len(wrong)
                if wrong:
                    cases = [(in_line(number), text) for number, text in wrong[:5]]
                    findings.note(
                        Kind.UNREADABLE, path.name, "", cases, len(wrong), "no row of numbers; left out"
                    )
            good += len(values)
            if not good and bad >= HOPELESS:
                break
            for column, scale in scales.items():
                values[:, column] *= scale
            found = np.array(places, dtype=np.int64)
            values, found = _with_time(values, found, times, path.name, findings)
            if len(values):
                yield values, found
    if not good:
        what = "it is empty" if not bad else "none of its lines is a row of numbers"
        raise UserError(
            f"{path}: {what}; wanted are at least {max(columns) + 1} columns"
            f" {'between white space' if delimiter is None else f'between {delimiter!r}'}"
        )


def _opened(path: Path) -> TextIO:
    return path.open(encoding="utf-8-sig", errors="replace", newline=None)


def _blocks(
    file: TextIO, skip: int, comments: str, meter: Callable[[int], None]
) -> Iterator[tuple[list[str], list[int]]]:
    lines: list[str] = []
    numbers: list[int] = []
    number = size = 0
    while line := file.readline(LONGEST_LINE):
        number += 1
        size += len(line)
        if number <= skip:
            continue
        text = line.strip()
        if not text or text[0] in comments:
            continue
        lines.append(text)
        numbers.append(number)
        if len(lines) == ROWS_AT_ONCE:
            meter(size)
            yield lines, numbers
            lines, numbers, size = [], [], 0
    meter(size)
    if lines:
        yield lines, numbers


def _fast(lines: list[str], columns: Sequence[int], delimiter: str | None) -> Floats | None:
    try:
        values: Floats = np.loadtxt(
            lines, dtype=np.float64, comments=None, delimiter=delimiter, usecols=columns, ndmin=2
        )
    except (ValueError, IndexError, OverflowError):
        return None
    return values if len(values) == len(lines) else None


def _slow(
    lines: list[str],
    numbers: list[int],
    columns: Sequence[int],
    delimiter: str | None,
    readers: Sequence[Cell],
) -> tuple[Floats, list[int], list[tuple[int, str]]]:
    rows: list[list[float]] = []
    places: list[int] = []
    wrong: list[tuple[int, str]] = []
    for line, number in zip(lines, numbers, strict=True):
        if delimiter is not None and '"' in line:
            parts = next(csv.reader([line], delimiter=delimiter), [])
        else:
            parts = line.split(delimiter)
        try:
            rows.append([read(parts[column]) for read, column in zip(readers, columns, strict=True)])
            places.append(number)
        except (ValueError, IndexError, OverflowError, csv.Error):
            wrong.append((number, repr(line[:SHOWN])))
    return np.array(rows, dtype=np.float64).reshape(-1, len(columns)), places, wrong


def _with_time(
    values: Floats, lines: Integers, times: Sequence[int], file: str, findings: Findings
) -> tuple[Floats, Integers]:
    told = values[:, list(times)]
    sound = (np.abs(told) < LATEST_S).all(axis=1)
    if sound.all():
        return values, lines
    which = np.flatnonzero(~sound)
    cases = [(in_line(int(lines[i])), str(told[i].tolist())[1:-1]) for i in which[:5]]
    findings.note(Kind.NOT_FINITE, file, "time", cases, len(which), "left out")
    return values[sound], lines[sound]


def _number(text: str) -> float:
    text = text.strip().strip('"')
    return float(text) if text else math.nan


def ns_of_seconds(seconds: Floats) -> Integers:
    """Whole and fractional part apart: nothing is lost that a float64 of seconds holds."""
    whole = np.floor(seconds)
    return whole.astype(np.int64) * NS + np.rint((seconds - whole) * 1e9).astype(np.int64)
