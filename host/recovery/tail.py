"""The end of a capture: what is needed to decode again what its run had not come to.

A run looks at what came over its wires every `host.run.session.CHUNK_NS` at the latest; a capture that was
cut off ends with raw traffic of up to that long whose decoded rows are missing. The bytes of the host port
are kept for somewhat longer than that, everything else for the whole file: there is little of it.
"""

from __future__ import annotations

import json
from collections import Counter, deque
from typing import Any

from host.capture.blocks import MARK, MARK_TOPIC, UartChunk, uart_topic, unpack
from host.capture.location_fix import TOPICS
from host.capture.reader import RawMessage
from host.capture.topics import CLOCK, CONTROL, EVENTS, TABLES
from host.run.arrivals import Piece
from host.run.intake import HOST_PORT
from host.run.session import CHUNK_NS

KEPT_NS = CHUNK_NS + CHUNK_NS // 2
HOST_LINE = uart_topic(HOST_PORT, "tx")
DECODED = (*TABLES, *TOPICS.values())


class Tail:
    """Fed with every message of a capture in the order of the file."""

    def __init__(self) -> None:
        self.mark_ns = 0
        """Everything up to here is in the file."""
        self.last_ns: dict[str, int] = {}
        """Of each decoded topic the last row's time."""
        self._blocks: deque[RawMessage] = deque()
        self._words: dict[str, list[bytes]] = {EVENTS[0]: [], CLOCK[0]: [], CONTROL[0]: []}

    def add(self, message: RawMessage) -> None:
        """One more message."""
        topic = message.topic
        if topic == MARK_TOPIC and len(message.data) == MARK.size:
            (self.mark_ns,) = MARK.unpack(message.data)
            while self._blocks and self._blocks[0].time_ns < self.mark_ns - KEPT_NS:
                self._blocks.popleft()
        elif topic == HOST_LINE:
            self._blocks.append(message)
        elif topic in DECODED:
            self.last_ns[topic] = max(self.last_ns.get(topic, -1), message.time_ns)
        elif topic in self._words:
            self._words[topic].append(message.data)

    @property
    def tells_clocks(self) -> bool:
        """Whether it is known when clocks began to count: since format 4."""
        return bool(self._words[CLOCK[0]])

    def clocks(self) -> list[dict[str, Any]]:
        """Messages of /clock."""
        return [json.loads(text) for text in self._words[CLOCK[0]]]

    def commands(self) -> list[dict[str, Any]]:
        """What was done to the board from outside."""
        return [json.loads(text) for text in self._words[CONTROL[0]]]

    def texts(self) -> Counter[tuple[int, str]]:
        """What the board has said and when, as far as it was decoded."""
        events = [json.loads(text) for text in self._words[EVENTS[0]]]
        said = [(round(e["t_s"] * 1e9), e["text"]) for e in events if e["source"] == "board"]
        return Counter(said)

    def pieces(self) -> list[Piece]:
        """What the board sent to the host in the last minutes, and when the last byte of each piece ended."""
        found: list[Piece] = []
        for block in self._blocks:
            for record in unpack(block.schema.name, block.topic, block.data):
                assert isinstance(record, UartChunk)
                found.append((record.data, record.end_ns))
        return found
