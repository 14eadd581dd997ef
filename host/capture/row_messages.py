"""Rows of the decoded tables as the JSON messages of a capture."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from host.capture.location_fix import TOPICS, Fixes
from host.capture.topics import TABLES
from host.record.row_text import RowText

RowTexts = tuple[str, list[int], list[bytes]]
"""Topic, times in ns, texts."""


class RowMessages:
    """Of one run: rows of a topic come in the order of time."""

    def __init__(self) -> None:
        self._texts = {
            topic: RowText.json(table.columns, table.decimals) for topic, (_schema, table) in TABLES.items()
        }
        self._fixes = {topic: Fixes.of(topic) for topic in TOPICS}

    def of(self, topic: str, rows: NDArray[np.float64]) -> list[RowTexts]:
        """Rows of a table ("/solution", "/gnss", …), column 0 the time in s; positions also as fixes."""
        times_ns = np.rint(np.maximum(rows[:, 0], 0.0) * 1e9).astype(np.int64).tolist()
        messages: list[RowTexts] = [(topic, times_ns, self._texts[topic].texts(rows))]
        if topic in self._fixes:
            fixes = list(self._fixes[topic].texts(rows))
            messages.append((TOPICS[topic], [t_ns for t_ns, _ in fixes], [text for _, text in fixes]))
        return messages


def event_message(t_ns: int, source: str, text: str) -> bytes:
    """A message of /event."""
    return json.dumps({"t_s": t_ns / 1e9, "source": source, "text": text}, separators=(",", ":")).encode()
