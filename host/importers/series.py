"""What importers hand over: rows of tables and raw records, in portions, on the recording's time axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from host.importers.units import Unit
from host.record.tables import Table

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

ROWS_AT_ONCE = 4096
EPOCHS_AT_ONCE = 256


@dataclass(frozen=True, eq=False)
class Series:
    """One stream of rows for one topic, and what is known of it."""

    topic: str
    schema: str
    table: Table
    """Column 0 is the time in s, filled in by the writer."""
    file: str
    place: Callable[[int], str]
    """Words for a row's place in the file."""
    needed: tuple[str, ...] = ()
    """Columns without which a row is worth nothing."""
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """What values can be at all."""
    watched: tuple[str, ...] = ()
    """Columns that never stand still while the sensor works."""
    units: Mapping[str, Unit] = field(default_factory=dict)
    """Of the quantities of this series, as the recording names them; empty: fixed by its format."""
    is_paced: bool = True
    """Whether rows follow one another at a steady rate; several rows may have one time when not."""

    def columns(self, *names: str) -> list[int]:
        """Places of columns in the values of rows."""
        return [self.table.columns.index(name) - 1 for name in names]


@dataclass(slots=True)
class Rows:
    """Some rows of a series."""

    series: Series
    times_ns: Integers
    values: Floats
    """(n, columns − 1): all but the time."""
    places: Integers

    def __len__(self) -> int:
        return len(self.times_ns)

    def only(self, keep: NDArray[np.bool_]) -> Rows:
        """Those of the rows."""
        return Rows(self.series, self.times_ns[keep], self.values[keep], self.places[keep])

    @property
    def first_ns(self) -> int:
        """Where it belongs among other portions."""
        return int(self.times_ns[0])


@dataclass(slots=True)
class RawRecords:
    """Records for a raw topic; their times are put in when the origin of time is known."""

    topic: str
    schema: str
    records: list[tuple[int, Callable[[int], bytes]]]
    """(time in ns, record with that time in ns since the origin)."""

    @property
    def first_ns(self) -> int:
        """Where it belongs among other portions."""
        return self.records[0][0]


Portion = Rows | RawRecords
Stream = Iterator[Portion]


def in_line(number: int) -> str:
    """Place in a text file."""
    return f"line {number}"


def in_record(number: int) -> str:
    """Place in a list of records."""
    return f"record {number}"


def at_byte(number: int) -> str:
    """Place in a log of bytes."""
    return f"byte {number}"


def portions(series: Series, times_ns: Integers, values: Floats, places: Integers) -> Iterator[Rows]:
    """A whole array in portions."""
    for begin in range(0, len(times_ns), ROWS_AT_ONCE):
        part = slice(begin, begin + ROWS_AT_ONCE)
        yield Rows(series, times_ns[part], values[part], places[part])
