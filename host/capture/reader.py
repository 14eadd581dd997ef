"""Reads a capture, whole or cut off by a crash, from front to back.

The index at the end of the file is not needed: chunks are read one after another in the order in which they
were written, each checked by its CRC, and reading stops at the first one that is not whole. Records come in
the order of time within one wire or topic; different ones are interleaved chunk by chunk.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

from host.capture.blocks import SCHEMAS, Traffic, unpack
from host.record.errors import UserError

LONGEST_RECORD = 1 << 30
FIRST_FORMAT = "navtwin-capture-1"
"""Of captures that name none: no pins, no marks, lines into the board with the ends of their bytes only."""


@dataclass(frozen=True, slots=True)
class Decoded:
    """One JSON message: an event, or a row of a table with its columns as keys."""

    topic: str
    time_ns: int
    value: dict[str, Any]


class CaptureReader:
    """One capture file. Iterate once to get its records; afterwards `complete` tells whether it was whole."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.manifest: dict[str, Any] = {}
        self.summary: dict[str, str] | None = None
        """The metadata that a finished run wrote at its end; None for one that was cut off."""
        self.complete = False
        self.format = FIRST_FORMAT
        """Of the raw topics; known as soon as the first record has been given."""
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    def __iter__(self) -> Iterator[Traffic | Decoded]:
        try:
            file = self.path.open("rb")
        except OSError as error:
            raise UserError(f"capture {self.path}: cannot be read: {error.strerror}") from None
        with file:
            for record in self._records(file):
                if isinstance(record, Message):
                    yield from self._message(record)
                else:
                    self._note(record)

    def _records(self, file: BinaryIO) -> Iterator[McapRecord]:
        reader = StreamReader(file, validate_crcs=True, record_size_limit=LONGEST_RECORD)
        records = iter(reader.records)
        while True:
            try:
                record = next(records)
            except StopIteration:
                self.complete = True
                return
            except (McapError, ValueError, RuntimeError, struct.error) as error:
                if not self.manifest:
                    reason = str(error) or "it ends before the manifest"
                    raise UserError(f"capture {self.path}: not a capture of navtwin: {reason}") from None
                return
            yield record

    def _note(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
        elif isinstance(record, Attachment) and record.name == "manifest.json":
            self.manifest = json.loads(record.data)
        elif isinstance(record, Metadata) and record.name == "end":
            self.summary = dict(record.metadata)
        elif isinstance(record, Metadata) and record.name == "capture":
            self.format = record.metadata["format"]

    def _message(self, message: Message) -> Iterator[Traffic | Decoded]:
        channel = self._channels[message.channel_id]
        schema = self._schemas[channel.schema_id].name
        if schema in SCHEMAS:
            yield from unpack(schema, channel.topic, message.data)
        else:
            yield Decoded(channel.topic, message.log_time, json.loads(message.data))
