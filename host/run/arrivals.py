"""When texts came: frames of kind TEXT hold no time, so theirs is that of the piece in which they ended."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from itertools import accumulate

from firmware.link.frames import CRC_LENGTH, HEADER_LENGTH, SYNC, TEXT

Piece = tuple[bytes, int]
"""Bytes of a line, and when the last of them ended, ns."""


class Arrivals:
    """The pieces of one batch; texts are asked for in their order."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.data = b"".join([data for data, _end_ns in pieces])
        self._pieces = pieces
        self._ends: list[int] = []
        """Of the pieces in `data`; made when the first text asks."""
        self._place = 0

    def text_ns(self, payload: bytes) -> int:
        """When the next text with this payload had come; one that began in an earlier batch ends in the
        first piece of this one."""
        if not self._ends:
            self._ends = list(accumulate(len(data) for data, _end_ns in self._pieces))
        end = self._place + 1
        at = self.data.find(SYNC + bytes((TEXT, len(payload))), self._place)
        while at >= 0:
            body = at + HEADER_LENGTH
            if self.data.startswith(payload, body):
                end = self._place = body + len(payload) + CRC_LENGTH
                break
            at = self.data.find(SYNC + bytes((TEXT, len(payload))), at + 1)
        piece = bisect_left(self._ends, end)
        return self._pieces[min(piece, len(self._pieces) - 1)][1]
