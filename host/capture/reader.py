"""Reads a capture, whole or cut off by a crash, from front to back.

The index at the end of the file is not needed: chunks are read one after another in the order in which they
were written, each checked by its CRC, and reading stops at the first one that is not whole. Records come in
the order of time within one wire or topic; different ones are interleaved chunk by chunk.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

from host.capture.blocks import MARK, MARK_TOPIC, SCHEMAS, Traffic, unpack
from host.capture.topics import CONTROL
from host.record.errors import UserError

LONGEST_RECORD = 1 << 30
LATEST_S = 9e9
"""Times of virtual time are below it, so that they fit into 64 bits of ns."""
FIRST_FORMAT = "navtwin-capture-1"
"""Of captures that name none: no pins, no marks, lines into the board with the ends of their bytes only."""


@dataclass(frozen=True, slots=True)
class Decoded:
    """One JSON message: an event, or a row of a table with its columns as keys."""

    topic: str
    time_ns: int
    value: dict[str, Any]


@dataclass(frozen=True, slots=True)
class RawMessage:
    """One message of the file."""

    topic: str
    encoding: str
    schema: Schema
    time_ns: int
    data: bytes

    @property
    def is_raw(self) -> bool:
        """Whether it is a block of raw records."""
        return self.schema.name in SCHEMAS


@dataclass(slots=True)
class Window:
    """The raw traffic up to a mark."""

    end_ns: int
    raw: dict[str, bytes]
    """Records of each topic, as in its blocks."""
    control: list[dict[str, Any]] = field(default_factory=list)
    """What was done to the board from outside (messages of /control)."""


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
        self._raw_schemas: dict[str, str | None] = {}
        self.whole_bytes = 0
        """So much of the file could be read."""

    def __iter__(self) -> Iterator[Traffic | Decoded]:
        for message in self.messages():
            if message.is_raw:
                yield from unpack(message.schema.name, message.topic, message.data)
            else:
                yield Decoded(message.topic, message.time_ns, self.row(message))

    def messages(self) -> Iterator[RawMessage]:
        """Every message as it stands in the file."""
        with self._opened() as file:
            for record in self._records(file):
                if not isinstance(record, Message):
                    self._note(record)
                    continue
                channel = self._channel(record)
                schema = self._schemas[channel.schema_id]
                yield RawMessage(
                    channel.topic, channel.message_encoding, schema, record.log_time, record.data
                )

    def row(self, message: RawMessage) -> dict[str, Any]:
        """The table in a JSON message. Raises UserError when there is none."""
        return self._parsed(message.data, f"a message of {message.topic}")

    def in_time_order(self, topics: Iterable[str]) -> Iterator[RawMessage]:
        """Messages of some topics by their times, wherever they stand; needs the index of a whole file."""
        from mcap.reader import make_reader

        with self._opened() as file:
            reader = make_reader(file)
            for schema, channel, message in reader.iter_messages(sorted(topics)):
                if schema is not None:
                    yield RawMessage(
                        channel.topic, channel.message_encoding, schema, message.log_time, message.data
                    )

    def windows(self) -> Iterator[Window]:
        """The raw traffic alone, from mark to mark, without unpacking it; the last one of a run that reached
        its end goes up to that end. What lies behind the last mark of any other is left out."""
        with self._opened() as file:
            raw: dict[str, list[bytes]] = {}
            control: list[dict[str, Any]] = []
            end_ns = 0
            for record in self._records(file):
                if not isinstance(record, Message):
                    self._note(record)
                    continue
                channel = self._channel(record)
                if channel.topic == MARK_TOPIC:
                    end_ns = self._mark(record.data)
                    yield Window(end_ns, _joined(raw), control)
                    raw, control = {}, []
                elif channel.topic == CONTROL[0]:
                    control.append(self._parsed(record.data, "a message of /control"))
                elif self.raw_schema(channel.topic) is not None:
                    raw.setdefault(channel.topic, []).append(record.data)
            if self.summary is not None and (last_ns := self.end_ns) is not None and last_ns >= end_ns:
                yield Window(last_ns, _joined(raw), control)

    def recorded_s(self) -> float | None:
        """Up to when the file goes, by its index; None: it has none, because its run was cut off."""
        from mcap.reader import make_reader

        try:
            with self._opened() as file:
                summary = make_reader(file).get_summary()
        except (McapError, ValueError, struct.error, OSError):
            return None
        if summary is None or summary.statistics is None:
            return None
        return float(summary.statistics.message_end_time) / 1e9

    @property
    def end_ns(self) -> int | None:
        """When the run ended, for one that reached its end and has been read so far."""
        seconds = (self.summary or {}).get("duration_s")
        if seconds is None:
            return None
        try:
            end_ns = round(float(seconds) * 1e9)
        except (ValueError, OverflowError):
            end_ns = -1
        if not 0 <= end_ns < LATEST_S * 1e9:
            raise UserError(
                f"capture {self.path}: its record of the end is damaged: duration_s is {seconds!r};"
                " a run writes seconds there, e.g. '60.0'"
            )
        return end_ns

    @property
    def cut_from_s(self) -> float:
        """Where it was cut to begin, known as soon as the first record has been given; 0: it was not."""
        return float(self.manifest.get("cut", {"from_s": 0.0})["from_s"])

    def raw_schema(self, topic: str) -> str | None:
        """Schema of a raw topic read by now; None: not raw."""
        if topic not in self._raw_schemas:
            names = [self._schemas[c.schema_id].name for c in self._channels.values() if c.topic == topic]
            self._raw_schemas[topic] = names[0] if names and names[0] in SCHEMAS else None
        return self._raw_schemas[topic]

    @property
    def raw_topics(self) -> list[str]:
        """The raw topics that have been declared by now."""
        return [c.topic for c in self._channels.values() if self.raw_schema(c.topic) is not None]

    @property
    def declared(self) -> list[tuple[str, str, Schema]]:
        """(topic, message encoding, schema) of all topics that have been declared by now."""
        return [
            (channel.topic, channel.message_encoding, self._schemas[channel.schema_id])
            for channel in self._channels.values()
        ]

    def _opened(self) -> BinaryIO:
        try:
            return self.path.open("rb")
        except OSError as error:
            raise UserError(f"capture {self.path}: cannot be read: {error.strerror}") from None

    def _records(self, file: BinaryIO) -> Iterator[McapRecord]:
        reader = StreamReader(file, validate_crcs=True, record_size_limit=LONGEST_RECORD)
        records = iter(reader.records)
        while True:
            try:
                record = next(records)
            except StopIteration:
                if not self.manifest:
                    raise self._foreign("it has no manifest") from None
                self.complete = True
                return
            except (McapError, ValueError, RuntimeError, struct.error) as error:
                if not self.manifest:
                    reason = str(error) or "it ends before the manifest"
                    raise self._foreign(reason) from None
                return
            self.whole_bytes = file.tell()
            yield record

    def _foreign(self, reason: str) -> UserError:
        return UserError(f"capture {self.path}: not a capture of navtwin: {reason}")

    def _note(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
            nameless = Schema(id=record.schema_id, name="", encoding="", data=b"")
            self._schemas.setdefault(record.schema_id, nameless)  # MCAP allows topics without a schema
        elif isinstance(record, Attachment) and record.name == "manifest.json":
            self.manifest = self._parsed(record.data, "its manifest")
            self._check_cut()
        elif isinstance(record, Metadata) and record.name == "end":
            self.summary = dict(record.metadata)
        elif isinstance(record, Metadata) and record.name == "capture":
            self.format = record.metadata.get("format", FIRST_FORMAT)

    def _channel(self, message: Message) -> Channel:
        channel = self._channels.get(message.channel_id)
        if channel is None:
            raise UserError(
                f"capture {self.path}: it is damaged: a message of topic number {message.channel_id}, which"
                " nothing in the file names"
            )
        return channel

    def _check_cut(self) -> None:
        cut = self.manifest.get("cut", {"from_s": 0.0, "to_s": 0.0})
        times = [cut.get(name) for name in ("from_s", "to_s")] if isinstance(cut, dict) else [None]
        if not all(isinstance(one, int | float) and 0.0 <= one < LATEST_S for one in times):
            raise UserError(
                f"capture {self.path}: its manifest is damaged: 'cut' is {cut!r:.60}; navtwin capture cut"
                ' writes there, e.g., {"from_s": 60.0, "to_s": 120.0}'
            )

    def _mark(self, data: bytes) -> int:
        if len(data) != MARK.size:
            raise UserError(f"capture {self.path}: {MARK_TOPIC} is damaged: a mark of {len(data)} bytes")
        return int(MARK.unpack(data)[0])

    def _parsed(self, text: bytes, what: str) -> dict[str, Any]:
        try:
            found = json.loads(text)
        except ValueError as error:
            raise UserError(f"capture {self.path}: {what} is damaged: {error}") from None
        if not isinstance(found, dict):
            raise self._foreign(f"{what} is no table")
        return found


def _joined(raw: dict[str, list[bytes]]) -> dict[str, bytes]:
    return {topic: b"".join(blocks) for topic, blocks in raw.items()}
