"""Writes an MCAP file in few, large steps: records of the format (mcap.dev/spec), packed where they arise.

    magic | header, attachments, metadata | chunk, message indexes | … | data end | summary | footer | magic

A message is packed into the chunk at work when it comes, and a chunk is handed over whole, compressed by
LZ4. Of a chunk that is written only its packed index record is kept for the summary. What is written once in
a file is packed by the records of the package `mcap`; the bytes are those that its own writer makes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from struct import Struct
from typing import Any, BinaryIO
from zlib import crc32

import lz4.frame
import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

COMPRESSION = b"lz4"
RECORD_HEAD = Struct("<BQ")
MESSAGE_HEAD = Struct("<BQHIQQ")
MESSAGE_FIELDS = 22
"""Bytes of a message before its data."""
CHUNK_HEAD = Struct(f"<BQQQQII{len(COMPRESSION)}sQ")
CHUNK_FIELDS = CHUNK_HEAD.size - RECORD_HEAD.size
INDEX_HEAD = Struct("<BQHI")
INDEX_FIELDS = INDEX_HEAD.size - RECORD_HEAD.size
INDEX_ENTRY = Struct("<QQ")
CHUNK_INDEX_HEAD = Struct("<BQQQQQI")
CHUNK_INDEX_OFFSET = Struct("<HQ")
CHUNK_INDEX_END = Struct(f"<QI{len(COMPRESSION)}sQQ")
FOOTER_START = Struct("<BQQQ")
FOOTER_FIELDS = 20
NO_TIME = 1 << 63
MESSAGE_HEADS = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_ns", "<u8"),
        ("publish_ns", "<u8"),
    ]
)
"""MESSAGE_HEAD, side by side."""
Integers = NDArray[np.int64]
Octets = NDArray[np.uint8]


class McapFile:
    """One file on an empty stream that the caller opens and closes."""

    def __init__(self, stream: BinaryIO, profile: str, library: str) -> None:
        self._stream = stream
        self._chunk = bytearray()
        self._first_ns, self._last_ns = NO_TIME, 0
        self._indexes: dict[int, bytearray] = {}
        """Of the chunk at work: time and place of every message, by channel."""
        self._chunk_indexes: list[bytes] = []
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}
        """Messages by channel."""
        self._file_first_ns, self._file_last_ns = NO_TIME, 0
        self._at = 0
        """Bytes of the file so far."""
        self._write(MCAP0_MAGIC + _packed(Header(profile, library)))

    # -- what is in the file once ------------------------------------------------------------------

    def register_schema(self, name: str, encoding: str, data: bytes) -> int:
        """A further schema; returns its number."""
        schema = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._schemas.append(schema)
        self._chunk += _packed(schema)
        return schema.id

    def register_channel(self, topic: str, message_encoding: str, schema_id: int) -> int:
        """A further channel; returns its number."""
        number = len(self._channels) + 1
        channel = Channel(
            id=number, topic=topic, message_encoding=message_encoding, schema_id=schema_id, metadata={}
        )
        self._channels.append(channel)
        self._chunk += _packed(channel)
        return number

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """A file within the file, without a time."""
        attachment = Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data)
        offset, length = self._write(_packed(attachment))
        self._attachments.append(
            AttachmentIndex(
                offset=offset,
                length=length,
                create_time=0,
                log_time=0,
                data_size=len(data),
                name=name,
                media_type=media_type,
            )
        )

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Words and their values."""
        offset, length = self._write(_packed(Metadata(name=name, metadata=dict(data))))
        self._metadata.append(MetadataIndex(offset=offset, length=length, name=name))

    # -- messages ----------------------------------------------------------------------------------

    def add_message(self, channel: int, time_ns: int, data: bytes | bytearray) -> None:
        """A message of one channel, into the chunk at work."""
        chunk = self._chunk
        try:
            index = self._indexes[channel]
        except KeyError:
            index = self._indexes[channel] = bytearray()
        index += INDEX_ENTRY.pack(time_ns, len(chunk))
        if time_ns < self._first_ns:
            self._first_ns = time_ns
        if time_ns > self._last_ns:
            self._last_ns = time_ns
        chunk += MESSAGE_HEAD.pack(Opcode.MESSAGE, MESSAGE_FIELDS + len(data), channel, 0, time_ns, time_ns)
        chunk += data

    def add_texts(self, channel: int, times_ns: Sequence[int], texts: Sequence[bytes]) -> None:
        """Messages of one channel, one after another."""
        if not texts:
            return
        place = len(self._chunk)
        entry, head = INDEX_ENTRY.pack, MESSAGE_HEAD.pack
        entries: list[bytes] = []
        records: list[bytes] = []
        for t_ns, text in zip(times_ns, texts, strict=True):
            entries.append(entry(t_ns, place))
            length = MESSAGE_FIELDS + len(text)
            records += (head(Opcode.MESSAGE, length, channel, 0, t_ns, t_ns), text)
            place += RECORD_HEAD.size + length
        self._chunk += b"".join(records)
        self._indexes.setdefault(channel, bytearray()).extend(b"".join(entries))
        self._first_ns = min(self._first_ns, *times_ns)
        self._last_ns = max(self._last_ns, *times_ns)

    def add_messages(self, channel: int, times_ns: Integers, texts: Octets, ends: Integers) -> None:
        """Many messages of one channel at once: `ends` tells where each one ends in `texts`."""
        count = len(ends)
        if not count:
            return
        heads = np.zeros(count, MESSAGE_HEADS)
        heads["opcode"], heads["channel"] = Opcode.MESSAGE, channel
        heads["length"] = MESSAGE_FIELDS + np.diff(ends, prepend=0)
        heads["log_ns"] = heads["publish_ns"] = times_ns
        size = MESSAGE_HEADS.itemsize
        begins = size * np.arange(count) + np.concatenate(([0], ends[:-1]))
        entries = np.empty((count, 2), "<u8")
        entries[:, 0], entries[:, 1] = times_ns, len(self._chunk) + begins
        self._indexes.setdefault(channel, bytearray()).extend(entries.tobytes())
        records = np.empty(size * count + ends[-1], np.uint8)
        is_text = np.ones(len(records), np.bool_)
        places = begins[:, None] + np.arange(size)
        is_text[places] = False
        records[places] = heads.view(np.uint8).reshape(count, size)
        records[is_text] = texts[: ends[-1]]
        self._chunk += records.tobytes()
        self._first_ns = min(self._first_ns, int(times_ns.min()))
        self._last_ns = max(self._last_ns, int(times_ns.max()))

    @property
    def waiting_bytes(self) -> int:
        """Of the chunk at work."""
        return len(self._chunk)

    def flush(self) -> None:
        """Write the chunk at work, if there are messages in it, and hand everything to the system."""
        if self._indexes:
            self._write_chunk()
        self._stream.flush()

    def _write_chunk(self) -> None:
        chunk, indexes = self._chunk, self._indexes
        size, compressed = len(chunk), lz4.frame.compress(chunk)
        span = self._first_ns, self._last_ns
        head = CHUNK_HEAD.pack(
            Opcode.CHUNK,
            CHUNK_FIELDS + len(compressed),
            *span,
            size,
            crc32(chunk),
            len(COMPRESSION),
            COMPRESSION,
            len(compressed),
        )
        begin = self._at
        length = len(head) + len(compressed)
        pieces, offsets, at = [head, compressed], [], begin + length
        for channel, index in indexes.items():
            offsets.append(CHUNK_INDEX_OFFSET.pack(channel, at))
            pieces += [
                INDEX_HEAD.pack(Opcode.MESSAGE_INDEX, INDEX_FIELDS + len(index), channel, len(index)),
                index,
            ]
            at += INDEX_HEAD.size + len(index)
            self._counts[channel] = self._counts.get(channel, 0) + len(index) // INDEX_ENTRY.size
        self._write(b"".join(pieces))
        table = b"".join(offsets)
        end = CHUNK_INDEX_END.pack(at - begin - length, len(COMPRESSION), COMPRESSION, len(compressed), size)
        fields = CHUNK_INDEX_HEAD.size - RECORD_HEAD.size + len(table) + len(end)
        told = CHUNK_INDEX_HEAD.pack(Opcode.CHUNK_INDEX, fields, *span, begin, length, len(table))
        self._chunk_indexes.append(told + table + end)
        self._file_first_ns = min(self._file_first_ns, span[0])
        self._file_last_ns = max(self._file_last_ns, span[1])
        chunk.clear()
        indexes.clear()
        self._first_ns, self._last_ns = NO_TIME, 0

    # -- the end -----------------------------------------------------------------------------------

    def finish(self) -> None:
        """Write what is left and the summary; the stream stays open."""
        self.flush()
        self._write(_packed(DataEnd(0)))
        begin = self._at
        groups = (
            (Opcode.SCHEMA, list(map(_packed, self._schemas))),
            (Opcode.CHANNEL, list(map(_packed, self._channels))),
            (Opcode.STATISTICS, [_packed(self._statistics())]),
            (Opcode.CHUNK_INDEX, self._chunk_indexes),
            (Opcode.ATTACHMENT_INDEX, list(map(_packed, self._attachments))),
            (Opcode.METADATA_INDEX, list(map(_packed, self._metadata))),
        )
        summary, offsets = bytearray(), []
        for opcode, records in groups:
            start = len(summary)
            summary += b"".join(records)
            offsets.append(SummaryOffset(opcode, begin + start, len(summary) - start))
        offsets_begin = begin + len(summary)
        summary += b"".join(map(_packed, offsets))
        check = crc32(FOOTER_START.pack(Opcode.FOOTER, FOOTER_FIELDS, begin, offsets_begin), crc32(summary))
        footer = Footer(summary_start=begin, summary_offset_start=offsets_begin, summary_crc=check)
        self._stream.write(bytes(summary) + _packed(footer) + MCAP0_MAGIC)

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunk_indexes),
            message_count=sum(self._counts.values()),
            metadata_count=len(self._metadata),
            message_start_time=0 if self._file_first_ns == NO_TIME else self._file_first_ns,
            message_end_time=self._file_last_ns,
            schema_count=len(self._schemas),
        )

    def _write(self, data: bytes) -> tuple[int, int]:
        """Where it stands in the file, and its length."""
        at, length = self._at, len(data)
        self._stream.write(data)
        self._at = at + length
        return at, length


def _packed(record: Any) -> bytes:
    """One record of the package `mcap`."""
    assert isinstance(record, McapRecord)
    builder = RecordBuilder()
    record.write(builder)
    packed: bytes = builder.end()
    return packed
