"""Captures in the formats of other tools."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from boards.hints import did_you_mean
from host.capture.blocks import (
    CanMessage,
    I2cTransaction,
    LineCut,
    LinePiece,
    PinEdge,
    SpiTransaction,
    Traffic,
    UartChunk,
    i2c_topic,
)
from host.capture.reader import CaptureReader, Decoded
from host.capture.tables_of import Row, row_of
from host.record.atomic import made_aside
from host.record.errors import UserError

ROWS_AT_ONCE = 20_000
LONGEST_CLASSIC_CAN = 8
"""Bytes in a frame; imported logs of CAN FD have longer ones."""
SPI_SELECT = "select"
I2C_BUSY = "busy"
TEXTS = (
    "command",
    "arguments",
    "mosi",
    "miso",
    "data",
    "source",
    "text",
    "frame_id",
    "written",
    "read",
    "refusal",
    "sender",
    "processor",
)
INTEGERS = ("identifier", "baud", "address", "acknowledged", "asked", "reset_ns", "rate_ppb")


def export(reader: CaptureReader, kind: str, target: Path, topic: str | None) -> list[Path]:
    """Write a capture, or one topic of it, as `kind`; returns the files made.

    csv, parquet: a folder with one file a topic; nmea, candump, vcd: one file. Raises UserError.
    """
    if kind not in KINDS:
        raise UserError(f"--format {kind}: no such format; {did_you_mean(kind, KINDS)}")
    if target.exists() and (target.is_file() or any(target.iterdir())):
        raise UserError(f"-o {target}: exists already; name a new file or folder")
    with made_aside(target, "-o") as part:
        made = KINDS[kind](reader, part, topic)
        if not made:
            what = "" if topic is None else f" under {topic}"
            raise UserError(f"capture {reader.path}: holds nothing for {kind}{what}")
    return [target / path.name if path.parent == part else target for path in made]


def _tables(reader: CaptureReader, topic: str | None) -> Iterator[tuple[str, list[Row]]]:
    """Rows in portions, topic by topic as they come."""
    waiting: dict[str, list[Row]] = {}
    for record in reader:
        found = row_of(record)
        if found is None or (topic is not None and found[0] != topic):
            continue
        name, row = found
        rows = waiting.setdefault(name, [])
        rows.append(row)
        if len(rows) >= ROWS_AT_ONCE:
            yield name, rows
            waiting[name] = []
    yield from ((name, rows) for name, rows in waiting.items() if rows)


def file_name(topic: str) -> str:
    """Of a topic: /uart/gnss/rx becomes uart-gnss-rx."""
    return topic.strip("/").replace("/", "-")


def _csv(reader: CaptureReader, target: Path, topic: str | None) -> list[Path]:
    target.mkdir(parents=True, exist_ok=True)
    columns: dict[str, list[str]] = {}
    for name, rows in _tables(reader, topic):
        is_new = name not in columns
        known = columns.setdefault(name, _columns_of(rows))
        _check_columns(reader, name, rows, known)
        with _csv_of(target, name).open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, known)
            if is_new:
                writer.writeheader()
            writer.writerows(rows)
    return [_csv_of(target, name) for name in columns]


def _csv_of(folder: Path, topic: str) -> Path:
    return folder / f"{file_name(topic)}.csv"


def _columns_of(rows: list[Row]) -> list[str]:
    """Of all rows, in the order in which they come."""
    return list(dict.fromkeys(name for row in rows for name in row))


def _check_columns(reader: CaptureReader, topic: str, rows: list[Row], known: list[str]) -> None:
    """The header is written by now. Raises UserError for columns that only later rows have."""
    later = next((name for row in rows for name in row if name not in known), None)
    if later is not None:
        raise UserError(
            f"capture {reader.path}: {topic} is damaged: its later rows have a column {later!r}, which the"
            f" first {ROWS_AT_ONCE:,} do not have"
        )


def _parquet(reader: CaptureReader, target: Path, topic: str | None) -> list[Path]:
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise UserError("--format parquet needs pyarrow: pip install 'navtwin[campaign]'") from None
    target.mkdir(parents=True, exist_ok=True)
    writers: dict[str, Any] = {}
    made: dict[str, Path] = {}
    try:
        for name, rows in _tables(reader, topic):
            if name not in writers:
                fields = [(column, _arrow_type(pa, column)) for column in _columns_of(rows)]
                made[name] = target / f"{file_name(name)}.parquet"
                writers[name] = parquet.ParquetWriter(made[name], pa.schema(fields))
            try:
                writers[name].write_table(pa.Table.from_pylist(rows, writers[name].schema))
            except (pa.ArrowException, OverflowError) as error:
                raise UserError(f"capture {reader.path}: {name} is damaged: {error}") from None
    finally:
        for writer in writers.values():
            writer.close()
    return list(made.values())


def _arrow_type(pa: Any, column: str) -> Any:
    if column in TEXTS:
        return pa.string()
    if column in INTEGERS:
        return pa.int64()
    return pa.bool_() if column == "extended" else pa.float64()


def _nmea(reader: CaptureReader, target: Path, topic: str | None) -> list[Path]:
    """Sentences that came into a UART, with a checksum that is right, one a line."""
    lines: dict[str, bytearray] = {}
    sentences = 0
    with target.open("wb") as file:
        for record in reader:
            if isinstance(record, LineCut | LinePiece) or (
                isinstance(record, UartChunk) and record.direction == "rx"
            ):
                if topic is not None and topic != f"/uart/{record.port}/rx":
                    continue
                buffer = lines.setdefault(record.port, bytearray())
                buffer += b"\n" if isinstance(record, LineCut) else record.data
                *whole, rest = bytes(buffer).split(b"\n")
                lines[record.port] = bytearray(rest)
                good = [line for line in map(_sentence, whole) if line is not None]
                sentences += len(good)
                file.writelines(good)
    return [target] if sentences else []


def _sentence(line: bytes) -> bytes | None:
    """A line's sentence when its checksum is right."""
    start = line.rfind(b"$")
    body, star, checksum = line[start + 1 :].strip().partition(b"*")
    if start < 0 or not star:
        return None
    total = 0
    for byte in body:
        total ^= byte
    return b"$" + body + b"*" + checksum + b"\r\n" if checksum.upper() == b"%02X" % total else None


def _candump(reader: CaptureReader, target: Path, topic: str | None) -> list[Path]:
    from can import CanutilsLogWriter, Message

    frames = 0
    with CanutilsLogWriter(target) as writer:
        for record in reader:
            if isinstance(record, CanMessage) and topic in (None, f"/can/{record.bus}"):
                frames += 1
                writer.on_message_received(
                    Message(
                        timestamp=record.end_ns / 1e9,
                        arbitration_id=record.identifier,
                        is_extended_id=record.extended,
                        data=record.data,
                        is_fd=len(record.data) > LONGEST_CLASSIC_CAN,
                        channel=record.bus,
                    )
                )
    return [target] if frames else []


def _vcd(reader: CaptureReader, target: Path, topic: str | None) -> list[Path]:
    """Nets by their levels, chip selects by their low periods, I²C buses by their transactions.

    In order of time, so all of it in memory.
    """
    from vcd import VCDWriter

    changes: list[tuple[int, str, int]] = []
    for record in reader:
        changes += _levels(record, topic)
    if not changes:
        return []
    changes.sort(key=lambda change: change[0])
    with target.open("w", encoding="ascii") as file, VCDWriter(file, timescale="1 ns", date="") as writer:
        names = sorted({name for _time_ns, name, _level in changes})
        variables = {
            name: writer.register_var("board", name, "wire", size=1, init=int(name.endswith(SPI_SELECT)))
            for name in names
        }
        for time_ns, name, level in changes:
            writer.change(variables[name], time_ns, level)
    return [target]


def _levels(record: Traffic | Decoded, topic: str | None) -> list[tuple[int, str, int]]:
    if isinstance(record, PinEdge) and topic in (None, f"/pin/{record.net}"):
        return [(record.time_ns, record.net, int(record.level))]
    if isinstance(record, SpiTransaction) and topic in (None, f"/spi/{record.bus}"):
        name = f"{record.bus.replace('.', '_')}_{SPI_SELECT}"
        return [(record.start_ns, name, 0), (record.end_ns, name, 1)]
    if isinstance(record, I2cTransaction) and topic in (None, i2c_topic(record.bus)):
        name = f"{record.bus}_{I2C_BUSY}"
        return [(record.transfer.start_ns, name, 1), (record.transfer.end_ns, name, 0)]
    return []


KINDS: dict[str, Callable[[CaptureReader, Path, str | None], list[Path]]] = {
    "csv": _csv,
    "parquet": _parquet,
    "nmea": _nmea,
    "candump": _candump,
    "vcd": _vcd,
}
