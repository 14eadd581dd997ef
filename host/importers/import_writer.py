"""Writes an imported capture: an MCAP file like that of a run, with topics that may come up at any time.

It is written aside and gets its name when it is whole. Chunks end by size, so memory stays flat however long
the recording is; what MCAP keeps for its index is some 100 bytes for each chunk and topic.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from host.capture.blocks import ENCODING, SCHEMAS
from host.capture.location_fix import LOCATION_FIX, Fixes
from host.capture.location_fix import schema as location_fix_schema
from host.capture.mcap_file import McapFile
from host.capture.topics import EVENTS, event_schema, table_schema
from host.capture.writer import CAPTURE_FORMAT
from host.importers.series import Integers, RawRecords, Rows, Series
from host.record.errors import UserError
from host.record.row_text import RowText

CHUNK_BYTES = 1 << 20
FIXES = {"/gnss": "/fix/gnss", "/truth": "/fix/truth"}


class ImportWriter:
    """One capture file in the making."""

    def __init__(self, path: Path, manifest: Mapping[str, Any], origin_ns: int) -> None:
        """`origin_ns`: where the virtual time of the capture begins. Raises UserError."""
        self.path = path
        self.part = path.with_name(path.name + ".part")
        self.origin_ns = origin_ns
        self.last_ns = 0
        self.counts: dict[str, int] = {}
        self._rows: dict[Series, tuple[int, RowText]] = {}
        self._fixes: dict[str, tuple[int, Fixes]] = {}
        self._raw: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        try:
            self._file: BinaryIO = self.part.open("wb")
        except OSError as error:
            raise UserError(f"-o {path}: cannot be written: {error.strerror}") from None
        self._writer = McapFile(self._file, profile="navtwin", library="navtwin")
        text = json.dumps(manifest, indent=1, sort_keys=True).encode()
        self._writer.add_attachment("manifest.json", "application/json", text)
        self._writer.add_metadata("capture", {"format": CAPTURE_FORMAT})

    def rows(self, rows: Rows) -> None:
        """Sound rows of a series."""
        if not len(rows):
            return
        series = rows.series
        if series not in self._rows:
            channel = self._channel(
                series.topic, "json", series.schema, table_schema(series.schema, series.table)
            )
            self._rows[series] = channel, RowText.json(series.table.columns, series.table.decimals)
        channel, text = self._rows[series]
        times_ns = rows.times_ns - self.origin_ns
        table = np.column_stack((times_ns / 1e9, rows.values))
        self._writer.add_messages(channel, np.maximum(times_ns, 0), *text.block(table))
        self._note(series.topic, len(rows), int(times_ns[-1]))
        if series.topic in FIXES:
            self._write_fixes(series, times_ns, table)
        self._end_chunk()

    def raw(self, raw: RawRecords) -> None:
        """Raw records, each as a message of its own portion of time."""
        if raw.topic not in self._raw:
            definition = SCHEMAS[raw.schema].encode()
            self._raw[raw.topic] = self._channel(raw.topic, ENCODING, raw.schema, definition, ENCODING)
        times = [time_ns - self.origin_ns for time_ns, _ in raw.records]
        block = b"".join([record(t_ns) for t_ns, (_, record) in zip(times, raw.records, strict=True)])
        first_ns = max(times[0], 0)
        self._writer.add_message(self._raw[raw.topic], first_ns, block)
        self._note(raw.topic, len(times), max(times))
        self._end_chunk()

    def event(self, source: str, text: str) -> None:
        """Something worth telling, at the end."""
        channel = self._channel(EVENTS[0], "json", EVENTS[1], event_schema())
        message = {"t_s": self.last_ns / 1e9, "source": source, "text": text}
        self._writer.add_message(channel, self.last_ns, json.dumps(message).encode())

    def close(self, summary: Mapping[str, str]) -> None:
        """End the file and give it its name. Raises UserError."""
        try:
            self._writer.flush()  # whoever reads of the end has read everything
            self._writer.add_metadata("end", dict(summary))
            self._writer.finish()
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()
            self.part.replace(self.path)
        except OSError as error:
            self.abandon()
            raise UserError(f"-o {self.path}: cannot be written: {error.strerror}") from None

    def abandon(self) -> None:
        """Leave nothing behind."""
        self._file.close()
        self.part.unlink(missing_ok=True)

    def _write_fixes(self, series: Series, times_ns: Integers, table: Any) -> None:
        topic = series.topic
        if topic not in self._fixes:
            channel = self._channel(FIXES[topic], "json", LOCATION_FIX, location_fix_schema())
            self._fixes[topic] = channel, Fixes.of_columns(series.table.columns)
        channel, fixes = self._fixes[topic]
        for t_ns, message in fixes.texts(table):
            self._writer.add_message(channel, t_ns, message)
            self._note(FIXES[topic], 1, t_ns)

    def _end_chunk(self) -> None:
        if self._writer.waiting_bytes >= CHUNK_BYTES:
            self._writer.flush()

    def _note(self, topic: str, count: int, last_ns: int) -> None:
        self.counts[topic] = self.counts.get(topic, 0) + count
        self.last_ns = max(self.last_ns, last_ns)

    def _channel(
        self, topic: str, encoding: str, schema: str, definition: bytes, schema_encoding: str = "jsonschema"
    ) -> int:
        if topic not in self._channels:
            if schema not in self._schemas:
                self._schemas[schema] = self._writer.register_schema(schema, schema_encoding, definition)
            self._channels[topic] = self._writer.register_channel(topic, encoding, self._schemas[schema])
        return self._channels[topic]
