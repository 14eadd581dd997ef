"""CAN logs, read by python-can: candump, ASC, BLF, TRC, CSV, MF4. Signals by a database, read by cantools.

A log is read as it comes. A line of candump that cannot be read is told and left out; in the other formats,
where one record tells how to read the next, everything behind such a record is.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import can
import cantools
import numpy as np

from host.capture.blocks import CAN_SCHEMA, EXTENDED, SENT_CAN_HEAD
from host.importers import topics
from host.importers.findings import Kind
from host.importers.request import InputFile, Recording, Task
from host.importers.series import ROWS_AT_ONCE, Portion, RawRecords, Rows, Series, in_record
from host.importers.time_base import NS, gps_from_unix
from host.record.errors import UserError

SUFFIXES = (".log", ".asc", ".blf", ".trc", ".csv", ".mf4", ".db")
LINES_AT_ONCE = 2000
LARGEST_SHORT, LARGEST_LONG = 0x7FF, 0x1FFF_FFFF
MOST_BYTES = 64
"""Of a frame of CAN FD."""
ABSOLUTE_S = 1e8
"""Times above this are Unix times; below, seconds since the log began."""
NO_NAME = re.compile(r"[^A-Za-z0-9_.-]+")
READING_ERRORS = (
    ValueError,
    IndexError,
    KeyError,
    TypeError,
    AttributeError,
    OverflowError,
    EOFError,
    OSError,
)


def read_can(task: Task) -> Recording:
    """All logs, on one clock."""
    database = _database(task.request.dbc)
    readers = [_Log(task, file, database) for file in task.request.files]
    bases = {reader.is_absolute for reader in readers}
    if len(bases) > 1:
        raise UserError(
            "import can: some of the logs have Unix times and some begin at 0; import each kind by itself"
        )
    return Recording([reader.portions() for reader in readers], is_absolute=bases == {True})


def _database(path: Path | None) -> Any:
    if path is None:
        return None
    try:
        return cantools.database.load_file(path, strict=False)
    except Exception as error:  # each format has errors of its own, and what is wrong stands in their text
        raise UserError(f"--dbc {path}: cannot be read as a CAN database: {str(error)[:300]}") from None


class _Log:
    """One log."""

    def __init__(self, task: Task, file: InputFile, database: Any) -> None:
        if file.path.suffix.lower() not in SUFFIXES:
            raise UserError(
                f"{file.path}: the name does not tell the format; python-can knows {', '.join(SUFFIXES)}"
                " (candump -L writes .log)"
            )
        self._task = task
        self._file = file
        self._database = database
        self._messages: dict[int, Any] = {}
        if database is not None:
            self._messages = {_key(one.frame_id, one.is_extended_frame): one for one in database.messages}
        self._series: dict[int, tuple[Series, Any]] = {}
        self._rows: dict[Series, list[tuple[int, list[float], int]]] = {}
        self._frames: dict[str, list[tuple[int, Callable[[int], bytes]]]] = {}
        self._last_ns: dict[str, int] = {}
        self._waiting = 0
        first = next(self._messages_of(_nothing, is_test=True), None)
        if first is None:
            raise UserError(
                f"{file.path}: no CAN frame in it that python-can can read; candump -L, for example, writes"
                " lines like (1707192000.000000) can0 123#11223344"
            )
        self.is_absolute = first.timestamp > ABSOLUTE_S

    def portions(self) -> Iterator[Portion]:
        """All frames, and what they say."""
        for number, message in enumerate(self._messages_of(self._task.meter), start=1):
            self._take(message, number)
            if self._waiting >= ROWS_AT_ONCE:
                yield from self._drain()
        yield from self._drain()

    def _messages_of(self, meter: Callable[[int], None], is_test: bool = False) -> Iterator[can.Message]:
        if self._file.path.suffix.lower() == ".log":
            yield from self._candump(meter, is_test)
            return
        number = 0
        try:
            with can.LogReader(self._file.path) as reader:
                for number, message in enumerate(reader, start=1):  # noqa: B007 - told when it breaks off
                    yield message
                whole = getattr(reader, "file_size", 0)
            if whole > self._file.path.stat().st_size and not is_test:
                case = (f"behind record {number}", f"it was {whole:,} bytes long")
                self._task.findings.note(Kind.CUT_OFF, self._file.name, "", [case])
        except Exception as error:  # readers of damaged files raise whatever they stumble over
            if not is_test:
                text = "what comes behind it cannot be read"
                case = (f"behind record {number}", f"{type(error).__name__}: {str(error)[:80]}")
                self._task.findings.note(Kind.UNREADABLE, self._file.name, "", [case], text=text)
        meter(self._file.path.stat().st_size)

    def _candump(self, meter: Callable[[int], None], is_test: bool) -> Iterator[can.Message]:
        with self._file.path.open(encoding="utf-8-sig", errors="replace") as file:
            first = 1
            while lines := file.readlines(LINES_AT_ONCE * 40):
                text = "".join(lines)
                try:
                    yield from list(can.CanutilsLogReader(io.StringIO(text)))
                except READING_ERRORS:
                    yield from self._line_by_line(lines, first, is_test)
                first += len(lines)
                meter(len(text))

    def _line_by_line(self, lines: list[str], first: int, is_test: bool) -> Iterator[can.Message]:
        for number, line in enumerate(lines, start=first):
            try:
                yield from list(can.CanutilsLogReader(io.StringIO(line)))
            except READING_ERRORS:
                if not is_test:
                    case = (f"line {number}", repr(line.strip()[:60]))
                    self._task.findings.note(Kind.UNREADABLE, self._file.name, "", [case], text="left out")

    def _take(self, message: can.Message, number: int) -> None:
        if message.is_error_frame or message.is_remote_frame:
            what = "error frames" if message.is_error_frame else "remote frames"
            self._task.findings.note(
                Kind.NOTE, self._file.name, what, [(in_record(number), "")], text="left out"
            )
            return
        if not 0.0 <= message.timestamp < 9e9:
            case = (in_record(number), f"{message.timestamp:g}")
            self._task.findings.note(Kind.NOT_FINITE, self._file.name, "time", [case], text="left out")
            return
        largest = LARGEST_LONG if message.is_extended_id else LARGEST_SHORT
        if not 0 <= message.arbitration_id <= largest or len(message.data) > MOST_BYTES:
            case = (in_record(number), f"identifier 0x{message.arbitration_id:X}, {len(message.data)} bytes")
            self._task.findings.note(Kind.IMPLAUSIBLE, self._file.name, "frame", [case], text="left out")
            return
        time_ns = self._time_ns(message.timestamp)
        bus = NO_NAME.sub("_", str(message.channel)) if message.channel is not None else "can0"
        last_ns = self._last_ns.get(bus)
        if last_ns is not None and time_ns < last_ns:
            case = (in_record(number), f"{(time_ns - last_ns) / NS:.6g} s")
            self._task.findings.note(Kind.BACK, self._file.name, f"/can/{bus}", [case], text="kept as it is")
        self._last_ns[bus] = time_ns if last_ns is None else max(time_ns, last_ns)
        self._frames.setdefault(bus, []).append((time_ns, _record(message)))
        self._waiting += 1
        if self._messages:
            self._decode(message, time_ns, number)

    def _time_ns(self, seconds: float) -> int:
        own = math.floor(seconds) * NS + round((seconds % 1.0) * 1e9)
        if not self.is_absolute:
            return own
        return int(gps_from_unix(np.array([own]), self._task.request.leap_seconds)[0])

    def _decode(self, message: can.Message, time_ns: int, number: int) -> None:
        key = _key(message.arbitration_id, message.is_extended_id)
        definition = self._messages.get(key)
        if definition is None:
            return
        if key not in self._series:
            self._series[key] = self._series_of(definition)
        series, signals = self._series[key]
        try:
            told = definition.decode(bytes(message.data), decode_choices=False, allow_truncated=True)
        except Exception as error:  # cantools' decoders raise errors of several libraries
            case = (in_record(number), f"{type(error).__name__}: {str(error)[:60]}")
            self._task.findings.note(
                Kind.UNREADABLE, self._file.name, definition.name, [case], text="not decoded"
            )
            return
        row = [math.nan] * len(signals)
        for place, signal in enumerate(signals):
            value = told.get(signal.name)
            if not isinstance(value, int | float):
                continue
            row[place] = float(value)
            low, high = signal.minimum, signal.maximum
            if low is not None and high is not None and low < high and _is_outside(value, low, high):
                case = (in_record(number), f"{value:g} outside {low:g} … {high:g}")
                channel = f"{definition.name}.{signal.name}"
                self._task.findings.note(Kind.IMPLAUSIBLE, self._file.name, channel, [case], text="kept")
        self._rows.setdefault(series, []).append((time_ns, row, number))

    def _series_of(self, definition: Any) -> tuple[Series, Any]:
        signals = list(definition.signals)
        names = [NO_NAME.sub("_", f"{one.name}_{one.unit}" if one.unit else one.name) for one in signals]
        unique = [name if names.count(name) == 1 else f"{name}_{k}" for k, name in enumerate(names)]
        name = NO_NAME.sub("_", definition.name)
        table = topics.table(
            *((_decimals(one.scale), name) for one, name in zip(signals, unique, strict=True))
        )
        series = topics.plain(
            f"/signals/{name}", f"dbc.{name}", table, self._file.name, in_record, is_paced=False
        )
        return series, signals

    def _drain(self) -> Iterator[Portion]:
        self._waiting = 0
        for bus, records in self._frames.items():
            if records:
                yield RawRecords(f"/can/{bus}", CAN_SCHEMA, list(records))
                records.clear()
        for series, rows in self._rows.items():
            if rows:
                times, values, places = zip(*rows, strict=True)
                yield Rows(series, np.array(times), np.array(values, dtype=np.float64), np.array(places))
                rows.clear()


def _is_outside(value: float, low: float, high: float) -> bool:
    """With room for what scaling rounds."""
    room = 1e-9 * (high - low)
    return not low - room <= value <= high + room


def _decimals(scale: float) -> int:
    """So many that a step of the raw number shows, and a digit more."""
    return min(12, max(0, 1 - math.floor(math.log10(abs(scale))))) if scale else 6


def _key(identifier: int, extended: bool) -> int:
    return identifier | EXTENDED * bool(extended)


def _record(message: can.Message) -> Callable[[int], bytes]:
    data = bytes(message.data)
    identifier = _key(message.arbitration_id, message.is_extended_id)
    return lambda t_ns: SENT_CAN_HEAD.pack(t_ns, identifier, len(data), 0) + data


def _nothing(_size: int) -> None:
    pass
