"""Rows of the decoded tables as the JSON messages of a capture."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from host.capture.location_fix import TOPICS, Fixes
from host.capture.topics import TABLES
from host.record.row_text import RowText

RowMessage = tuple[str, int, bytes]
"""Topic, time in ns, text."""


class RowMessages:
    """Of one run: rows of a topic come in the order of time."""

    def __init__(self) -> None:
        self._texts = {
            topic: RowText.json(table.columns, table.decimals) for topic, (_schema, table) in TABLES.items()
        }
        self._fixes = {topic: Fixes.of(topic) for topic in TOPICS}

    def of(self, topic: str, rows: NDArray[np.float64]) -> list[RowMessage]:
        """Rows of a table ("/solution", "/gnss", …), column 0 the time in s; positions also as fixes."""
        times_ns = np.rint(np.maximum(rows[:, 0], 0.0) * 1e9).astype(np.int64).tolist()
        texts = self._texts[topic].texts(rows)
        messages = [(topic, t_ns, text) for t_ns, text in zip(times_ns, texts, strict=True)]
        if topic in self._fixes:
            place = TOPICS[topic]
            messages += [(place, t_ns, text) for t_ns, text in self._fixes[topic].texts(rows)]
        return messages


def event_message(t_ns: int, source: str, text: str) -> bytes:
    """A message of /event."""
    return json.dumps({"t_s": t_ns / 1e9, "source": source, "text": text}, separators=(",", ":")).encode()
