"""A stretch of a capture as a capture of its own."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO

from mcap.records import Schema
from mcap.writer import CompressionType, Writer

from host.capture.blocks import MARK, MARK_TOPIC, spans, time_of
from host.capture.reader import CaptureReader, RawMessage
from host.capture.writer import UNBOUNDED
from host.record.atomic import made_aside
from host.record.errors import UserError

NS = 1_000_000_000


def cut(source: Path, target: Path, from_s: float, to_s: float) -> int:
    """Write what lies in [from_s, to_s) to `target`; returns the number of messages.

    The manifest says where it was cut; a capture cut at its end has no state hash any more. Raises UserError.
    """
    if not 0.0 <= from_s < to_s:
        raise UserError(
            f"--from {from_s:g} --to {to_s:g}: must be 0 or more and rise, e.g. --from 60 --to 120"
        )
    if target.exists():
        raise UserError(f"-o {target}: exists already; name a new file")
    reader = CaptureReader(source)
    copy: _Copy | None = None
    begin_ns, end_ns = round(from_s * NS), round(to_s * NS)
    with made_aside(target, "-o") as part, ExitStack() as opened:
        for message in reader.messages():
            if copy is None:
                copy = _Copy(opened.enter_context(part.open("wb")), reader, from_s, to_s)
            copy.take(message, begin_ns, end_ns)
        if copy is None or not copy.messages:
            raise UserError(f"capture {source}: nothing was recorded from {from_s:g} to {to_s:g} s")
        copy.finish(min(end_ns - 1, reader.end_ns or end_ns))
    return copy.messages


class _Copy:
    """A capture that takes messages of another one."""

    def __init__(self, file: BinaryIO, reader: CaptureReader, from_s: float, to_s: float) -> None:
        self.messages = 0
        self._writer = Writer(file, chunk_size=UNBOUNDED, compression=CompressionType.LZ4)
        self._writer.start(profile="navtwin", library="navtwin")
        manifest: dict[str, Any] = {**reader.manifest, "cut": {"from_s": from_s, "to_s": to_s}}
        text = json.dumps(manifest, indent=1, sort_keys=True).encode()
        self._writer.add_attachment(0, 0, "manifest.json", "application/json", text)
        self._writer.add_metadata("capture", {"format": reader.format})
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        for topic, encoding, schema in reader.declared:
            self._channel(topic, encoding, schema)

    def take(self, message: RawMessage, begin_ns: int, end_ns: int) -> None:
        """Copy what lies in the stretch."""
        data, time_ns = message.data, message.time_ns
        if message.is_raw:
            kept = [
                (time_of(record), data[first:last])
                for record, first, last in spans(message.schema.name, message.topic, data)
                if begin_ns <= time_of(record) < end_ns
            ]
            if not kept:
                return
            data, time_ns = b"".join([piece for _, piece in kept]), kept[0][0]
        elif not begin_ns <= time_ns < end_ns:
            return
        self._writer.add_message(
            self._channel(message.topic, message.encoding, message.schema), time_ns, data, time_ns
        )
        self.messages += 1
        if message.topic == MARK_TOPIC:
            self._writer.flush()

    def finish(self, end_ns: int) -> None:
        """Write the rest and the index."""
        if MARK_TOPIC in self._channels:
            self._writer.add_message(self._channels[MARK_TOPIC], end_ns, MARK.pack(end_ns), end_ns)
        self._writer.finish()

    def _channel(self, topic: str, encoding: str, schema: Schema) -> int:
        if topic not in self._channels:
            if schema.name not in self._schemas:
                self._schemas[schema.name] = self._writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            known = self._schemas[schema.name]
            self._channels[topic] = self._writer.register_channel(topic, encoding, known)
        return self._channels[topic]
