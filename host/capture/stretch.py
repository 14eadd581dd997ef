"""A stretch of a capture by its index: only the chunks that hold it are read.

A capture that was finished has an index of its chunks at its end, with the times of their messages. The first
window that is given may lack its beginning, the last one its end; so the stretch is asked for with a margin.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Chunk, ChunkIndex, McapRecord, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.summary import Summary

from host.capture.blocks import MARK, MARK_TOPIC
from host.capture.reader import LONGEST_RECORD, CaptureReader


class StretchReader(CaptureReader):
    """A reader to which a capture has only the chunks with messages from `from_ns` to `to_ns`."""

    def __init__(self, path: Path, from_ns: int, to_ns: int) -> None:
        super().__init__(path)
        self._from_ns = from_ns
        self._to_ns = to_ns

    def _records(self, file: BinaryIO) -> Iterator[McapRecord]:
        summary = _summary_of(file)
        file.seek(0)
        if summary is None or not summary.chunk_indexes:
            yield from super()._records(file)
            return
        for record in super()._records(file):
            if file.tell() > summary.chunk_indexes[0].chunk_start_offset:
                break
            yield record
        yield from summary.schemas.values()
        yield from summary.channels.values()
        file.seek(0)
        yield from make_reader(file).iter_metadata()
        try:
            marks = {channel.id for channel in summary.channels.values() if channel.topic == MARK_TOPIC}
            for index in self._wanted(summary):
                records = _chunk_at(file, index)
                yield from records
                if any(self._is_behind(record, marks) for record in records):
                    break
        except (McapError, ValueError, RuntimeError, struct.error):
            return
        self.complete = True

    def _is_behind(self, record: McapRecord, marks: set[int]) -> bool:
        """Whether it marks the end of a window behind the stretch. Decoded messages come late, so times of
        messages alone do not tell where traffic ends."""
        if not isinstance(record, Message) or record.channel_id not in marks:
            return False
        return len(record.data) == MARK.size and int(MARK.unpack(record.data)[0]) > self._to_ns

    def _wanted(self, summary: Summary) -> list[ChunkIndex]:
        """From the first chunk that overlaps to the last one."""
        chunks = sorted(summary.chunk_indexes, key=lambda index: index.chunk_start_offset)
        inside = [
            place
            for place, index in enumerate(chunks)
            if index.message_end_time >= self._from_ns and index.message_start_time <= self._to_ns
        ]
        return chunks[inside[0] : inside[-1] + 1] if inside else []


def _summary_of(file: BinaryIO) -> Summary | None:
    try:
        return make_reader(file).get_summary()
    except (McapError, ValueError, struct.error, OSError):
        return None


def _chunk_at(file: BinaryIO, index: ChunkIndex) -> list[McapRecord]:
    """The records of one chunk, their checksum proven."""
    file.seek(index.chunk_start_offset)
    reader = StreamReader(file, skip_magic=True, emit_chunks=True, record_size_limit=LONGEST_RECORD)
    chunk = next(iter(reader.records))
    return list(breakup_chunk(chunk, validate_crc=True)) if isinstance(chunk, Chunk) else []
