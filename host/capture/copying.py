"""A capture that takes messages of another one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, BinaryIO

from mcap.records import Schema

from host.capture.blocks import MARK, MARK_TOPIC
from host.capture.mcap_file import McapFile
from host.capture.reader import CaptureReader, RawMessage


class CaptureCopy:
    """Made when the source has given its first message; `changes` go into its manifest."""

    def __init__(self, file: BinaryIO, reader: CaptureReader, changes: Mapping[str, Any]) -> None:
        self.messages = 0
        self._writer = McapFile(file, profile="navtwin", library="navtwin")
        text = json.dumps({**reader.manifest, **changes}, indent=1, sort_keys=True).encode()
        self._writer.add_attachment("manifest.json", "application/json", text)
        self._writer.add_metadata("capture", {"format": reader.format})
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        for topic, encoding, schema in reader.declared:
            self._channel(topic, encoding, schema)

    def take(self, message: RawMessage) -> None:
        """One more message; a mark ends a chunk."""
        channel = self._channel(message.topic, message.encoding, message.schema)
        self._writer.add_message(channel, message.time_ns, message.data)
        self.messages += 1
        if message.topic == MARK_TOPIC:
            self._writer.flush()

    def mark(self, time_ns: int) -> None:
        """Everything up to here has been taken."""
        if MARK_TOPIC in self._channels:
            self._writer.add_message(self._channels[MARK_TOPIC], time_ns, MARK.pack(time_ns))

    def finish(self) -> None:
        """Write the rest and the index."""
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
