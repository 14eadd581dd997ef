"""Takes messages out of the bytes from the host: UBX frames and NMEA sentences in any mixture.

Garbage, wrong checksums, frames of absurd length and sentences that break off are skipped; the search
goes on right behind the start that led astray, so that a good message inside is still found. What is
incomplete waits for more bytes.
"""

from __future__ import annotations

from typing import NamedTuple

from boards.chips.neo_m8n.ubx import SYNC, fletcher
from boards.chips.receivers.sentence_input import DOLLAR, Sentence, sentence_at

LONGEST_PAYLOAD = 1024
"""A frame that announces more is taken for garbage."""
_HEADER = 6
_CHECK = 2


class UbxInput(NamedTuple):
    """A frame with a good checksum."""

    message_class: int
    message_id: int
    payload: bytes


class InputParser:
    """Bytes in, messages out."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def reset(self) -> None:
        """Forget what is incomplete."""
        self._buffer.clear()

    def feed(self, data: bytes) -> list[UbxInput | Sentence]:
        """The messages that `data` completes."""
        buffer = self._buffer
        buffer += data
        messages: list[UbxInput | Sentence] = []
        position = 0
        while position < len(buffer):
            first = buffer[position]
            message: UbxInput | Sentence | None
            if first == SYNC[0]:
                message, used = self._frame(position)
            elif first == DOLLAR:
                message, used = sentence_at(buffer, position)
            else:
                position = _next_start(buffer, position + 1)
                continue
            if used == 0:
                break
            if message is not None:
                messages.append(message)
            position += used
        del buffer[:position]
        return messages

    def _frame(self, start: int) -> tuple[UbxInput | None, int]:
        """A frame at `start` and its length; (None, 1) is not a frame, (None, 0) not complete yet."""
        buffer = self._buffer
        if len(buffer) > start + 1 and buffer[start + 1] != SYNC[1]:
            return None, 1
        if len(buffer) < start + _HEADER:
            return None, 0
        length = buffer[start + 4] | buffer[start + 5] << 8
        if length > LONGEST_PAYLOAD:
            return None, 1
        end = start + _HEADER + length
        if len(buffer) < end + _CHECK:
            return None, 0
        if fletcher(buffer[start + 2 : end]) != buffer[end : end + _CHECK]:
            return None, 1
        payload = bytes(buffer[start + _HEADER : end])
        return UbxInput(buffer[start + 2], buffer[start + 3], payload), _HEADER + length + _CHECK


def _next_start(buffer: bytearray, position: int) -> int:
    """Where the next message may begin."""
    starts = [found for found in (buffer.find(SYNC[:1], position), buffer.find(b"$", position)) if found >= 0]
    return min(starts, default=len(buffer))
